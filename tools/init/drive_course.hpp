// A drive as the proposed signals show it, on one grid: the speed and what goes with it.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "estimator/common/measurement.hpp"
#include "tools/init/proposal.hpp"
#include "tools/init/relation.hpp"

namespace odomd::tools {

class DriveCourse {
 public:
  explicit DriveCourse(const Proposal& proposal);

  [[nodiscard]] bool has(estimator::Source role) const {
    return place_.at(estimator::index_of(role)).has_value();
  }
  /// The car drives for some seconds.
  [[nodiscard]] bool has_motion() const;

  [[nodiscard]] double at(estimator::Source role, std::size_t i) const {
    return courses_.at(*place_.at(estimator::index_of(role)), i);
  }
  /// The mean of the wheels [m/s], and its change [m/s²].
  [[nodiscard]] double speed(std::size_t i) const { return speed_.value[i]; }
  [[nodiscard]] double acceleration(std::size_t i) const { return change_.value[i]; }

  /// f at each point where the car drives.
  [[nodiscard]] std::vector<double> moving(const std::function<double(std::size_t)>& f) const;

 private:
  std::array<std::optional<std::size_t>, estimator::source_count> place_;
  Courses courses_;
  Resampled speed_, change_;
  double least_speed_ = 0.0;
};

}  // namespace odomd::tools
