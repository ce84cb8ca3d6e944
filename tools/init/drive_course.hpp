// The drive as the proposed signals show it, where the car moves; and parts of check_behaviour() in
// files of their own.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "estimator/common/measurement.hpp"
#include "tools/identify/common/agreement.hpp"
#include "tools/identify/common/resampled.hpp"
#include "tools/init/proposal.hpp"

namespace odomd::tools {

/// Several signals on one grid over the time that all cover, as means over half a second, so that
/// smaller latencies hardly matter. Empty if they have less than that in common.
[[nodiscard]] std::vector<Resampled> on_one_grid(const std::vector<const Series*>& signals);

/// All signals at the same times; those at which the car stands or creeps are left out.
struct DriveCourse {
  explicit DriveCourse(const Proposal& proposal);

  [[nodiscard]] const Eigen::ArrayXd& of(estimator::Source role) const {
    return signals.at(estimator::index_of(role));
  }
  [[nodiscard]] bool has(estimator::Source role) const { return of(role).size() > 0; }
  /// Whether the car drives for three seconds.
  [[nodiscard]] bool has_motion() const { return speed.size() >= 60; }

  std::array<Eigen::ArrayXd, estimator::source_count> signals;  ///< empty: no such signal
  Eigen::ArrayXd speed, acceleration;  ///< the wheels' mean [m/s], and its rate of change [m/s²]
};

/// Takes a steering signal without a unit that stays within ±1 as a share of the full lock, or in
/// radians: sets its unit to none.
void take_command(Proposal& proposal);

/// Determines whether the steering angle is that of the front wheels or of the steering wheel, and
/// their ratio (if the wheelbase is known): sets the role's scale, with its reason or warning.
void set_steering_scale(Proposal& proposal, const DriveCourse& drive, const Car& car);

/// Sets each sigma for which the log shows another than odomd's default, and the offset of a gyro
/// that was at rest.
void set_noise(Proposal& proposal);

}  // namespace odomd::tools
