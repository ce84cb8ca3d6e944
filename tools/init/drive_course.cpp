#include "tools/init/drive_course.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace odomd::tools {

bool Relation::clear() const {
  constexpr double least = 0.6;
  constexpr std::size_t enough = 40;  // two seconds
  return count >= enough && std::fabs(correlation) >= least;
}

Relation relation_of(const std::vector<double>& y, const std::vector<double>& x) {
  Relation relation;
  relation.count = std::min(x.size(), y.size());
  if (relation.count < 3) return relation;
  const auto n = static_cast<double>(relation.count);
  double sum_x = 0.0, sum_y = 0.0;
  for (std::size_t i = 0; i < relation.count; ++i) {
    sum_x += x[i];
    sum_y += y[i];
  }
  double xx = 0.0, yy = 0.0, xy = 0.0;
  for (std::size_t i = 0; i < relation.count; ++i) {
    const double dx = x[i] - sum_x / n, dy = y[i] - sum_y / n;
    xx += dx * dx;
    yy += dy * dy;
    xy += dx * dy;
  }
  if (xx <= 0.0 || yy <= 0.0) return relation;
  relation.slope = xy / xx;
  relation.offset = (sum_y - relation.slope * sum_x) / n;
  relation.correlation = xy / std::sqrt(xx * yy);
  return relation;
}

std::vector<Resampled> on_one_grid(const std::vector<const Series*>& signals) {
  constexpr double step = 0.05, half = 0.25;  // s
  std::int64_t from = 0, to = 0;
  for (std::size_t i = 0; i < signals.size(); ++i) {
    if (signals[i]->empty()) return {};
    from = i == 0 ? signals[i]->t_ns.front() : std::max(from, signals[i]->t_ns.front());
    to = i == 0 ? signals[i]->t_ns.back() : std::min(to, signals[i]->t_ns.back());
  }
  const double length = 1e-9 * static_cast<double>(to - from);
  if (length < 2.0 * half) return {};
  std::vector<Resampled> all;
  all.reserve(signals.size());
  for (const Series* signal : signals)
    all.push_back(mean_around(resampled(*signal, from, 0.0, length, step), half));
  return all;
}

Relation relation_of(const Series& y, const Series& x) {
  const std::vector<Resampled> both = on_one_grid({&y, &x});
  return both.empty() ? Relation{} : relation_of(both[0].value, both[1].value);
}

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
  // At lower speeds the noise of a_y / v is too large.
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
