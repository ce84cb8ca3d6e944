#include "tools/init/drive_course.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

namespace odomd::tools {

std::vector<Resampled> on_one_grid(const std::vector<const Series*>& signals) {
  constexpr double step = 0.05, half = 0.25;  // s
  if (signals.empty() || std::ranges::any_of(signals, &Series::empty)) return {};
  std::int64_t from = signals[0]->t_ns.front(), to = signals[0]->t_ns.back();
  for (const Series* signal : signals) {
    from = std::max(from, signal->t_ns.front());
    to = std::min(to, signal->t_ns.back());
  }
  const double length = 1e-9 * static_cast<double>(to - from);
  if (length < 2.0 * half) return {};
  std::vector<Resampled> all;
  for (const Series* signal : signals)
    all.push_back(mean_around(resampled(*signal, from, 0.0, length, step), half));
  return all;
}

DriveCourse::DriveCourse(const Proposal& proposal) {
  std::vector<const Series*> found;
  std::vector<std::size_t> roles;
  for (std::size_t i = 0; i < proposal.roles.size(); ++i)
    if (const auto& choice = proposal.roles.at(i);
        choice && choice->series.size() > 1 &&
        choice->candidate.role != estimator::Source::direction) {
      found.push_back(&choice->series);
      roles.push_back(i);
    }
  const std::vector<Resampled> courses = on_one_grid(found);
  if (courses.empty()) return;
  Resampled mean{courses[0].begin, courses[0].step, std::vector(courses[0].value.size(), 0.0)};
  double wheels = 0.0;
  for (std::size_t k = 0; k < roles.size(); ++k)
    if (estimator::is_wheel(static_cast<estimator::Source>(roles[k]))) {
      mean = combined(mean, courses[k], std::plus{});
      ++wheels;
    }
  double fastest = 0.0;
  for (double& value : mean.value) {
    value /= std::max(wheels, 1.0);
    fastest = std::max(fastest, std::fabs(value));
  }
  // At lower speeds the noise of a_y / v is too large.
  const double least_speed = std::clamp(0.25 * fastest, 0.2, 3.0);
  const auto moving = [&](const Resampled& signal) {
    std::vector<double> values;
    for (std::size_t i = 0; i < mean.value.size(); ++i)
      if (std::fabs(mean.value[i]) > least_speed) values.push_back(signal.value[i]);
    return Eigen::ArrayXd(Eigen::Map<const Eigen::ArrayXd>(values.data(), std::ssize(values)));
  };
  for (std::size_t k = 0; k < roles.size(); ++k) signals.at(roles[k]) = moving(courses[k]);
  constexpr double around = 0.1;  // s
  speed = moving(mean);
  acceleration = moving(slope_around(mean, around));
}

}  // namespace odomd::tools
