#include "tools/init/drive_course.hpp"

#include <algorithm>
#include <cmath>

namespace odomd::tools {
namespace {

std::vector<const Series*> series_in(
    const Proposal& proposal,
    std::array<std::optional<std::size_t>, estimator::source_count>& place) {
  std::vector<const Series*> all;
  for (std::size_t i = 0; i < proposal.roles.size(); ++i)
    if (const auto& choice = proposal.roles.at(i);
        choice && choice->series.size() > 1 &&
        choice->candidate.role != estimator::Source::direction) {
      place.at(i) = all.size();
      all.push_back(&choice->series);
    }
  return all;
}

}  // namespace

DriveCourse::DriveCourse(const Proposal& proposal) : courses_(series_in(proposal, place_)) {
  if (courses_.size() == 0) return;
  speed_ = courses_.of(0);
  std::ranges::fill(speed_.value, 0.0);
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
  return courses_.each(f, [&](std::size_t i) { return std::fabs(speed(i)) > least_speed_; });
}

}  // namespace odomd::tools
