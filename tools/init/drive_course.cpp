#include "tools/init/drive_course.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace odomd::tools {

DriveCourse::DriveCourse(const Proposal& proposal) {
  std::vector<const Series*> signals;
  std::vector<std::size_t> roles;
  for (std::size_t i = 0; i < proposal.roles.size(); ++i)
    if (const auto& choice = proposal.roles.at(i);
        choice && choice->series.size() > 1 &&
        choice->candidate.role != estimator::Source::direction) {
      signals.push_back(&choice->series);
      roles.push_back(i);
    }
  std::vector<Resampled> found = on_one_grid(signals);
  if (found.empty()) return;
  speed_ = found.front();
  std::ranges::fill(speed_.value, 0.0);
  for (std::size_t i = 0; i < roles.size(); ++i) courses_.at(roles[i]) = std::move(found[i]);
  double wheels = 0.0;
  for (const estimator::Source role : wheel_sources)
    if (has(role)) {
      ++wheels;
      for (std::size_t i = 0; i < speed_.value.size(); ++i) speed_.value[i] += at(role, i);
    }
  if (wheels > 0.0)
    for (double& value : speed_.value) value /= wheels;
  constexpr double around = 0.1;  // s
  change_ = slope_around(speed_, around);
  // Slower than a quarter of its fastest, the noise of a_y / v is too large.
  double fastest = 0.0;
  for (const double value : speed_.value) fastest = std::max(fastest, std::fabs(value));
  least_speed_ = std::clamp(0.25 * fastest, 0.2, 3.0);
}

bool DriveCourse::has_motion() const {
  constexpr std::size_t enough = 60;  // 3 s
  return moving([](std::size_t) { return 0.0; }).size() >= enough;
}

std::vector<double> DriveCourse::moving(const std::function<double(std::size_t)>& f) const {
  std::vector<double> values;
  for (std::size_t i = 0; i < speed_.value.size(); ++i)
    if (std::fabs(speed(i)) > least_speed_) values.push_back(f(i));
  return values;
}

}  // namespace odomd::tools
