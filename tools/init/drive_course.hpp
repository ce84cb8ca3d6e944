// The proposed signals of a drive where the car moves, and those parts of check_behaviour() that
// have their own files.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "estimator/common/measurement.hpp"
#include "tools/identify/common/agreement.hpp"
#include "tools/identify/common/signal_log.hpp"
#include "tools/init/proposal.hpp"

namespace odomd::tools {

/// Several signals on one grid over the time that all of them cover, as means over half a second,
/// so that latencies below that hardly matter. Empty if all cover less than half a second
/// in common.
[[nodiscard]] std::vector<Resampled> on_one_grid(const std::vector<const Series*>& signals);

/// All signals at the same times, without those at which the car is at rest or creeps.
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

/// Sets the unit of a steering signal to none if its database gives no unit and it stays within ±1:
/// it is a command, or in radians.
void detect_command(Proposal& proposal);

/// Determines whether the steering angle is that of the front wheels or of the steering wheel and,
/// if the wheelbase is known, their ratio. Sets the scale of the role, with a reason or a warning.
void set_steering_scale(Proposal& proposal, const DriveCourse& drive, const Car& car);

/// Sets the sigmas that the log shows, and the offset of a gyro that was at rest.
void set_noise(Proposal& proposal);

}  // namespace odomd::tools
