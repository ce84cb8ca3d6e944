// The speed by integrating the measured acceleration.
//
// docs/model.md, "Integrity".
#pragma once

#include "estimator/integrity/parity.hpp"

namespace odomd::estimator::integrity {

/// Nothing is learnt at lower speeds [m/s].
inline constexpr double min_learning_speed = 0.3;

/// Integrates the measured acceleration over `dt` [s].
void integrate_acceleration(const Sensors& sensors, Observations& observed, double dt) noexcept;

/// Sets the integrated speed to 0 once the car stands. Call it while all wheels are distrusted.
void stop_with_locked_wheels(Observations& observed) noexcept;

/// What the integrated speed is compared with.
struct SpeedReference {
  bool accel_usable = false;  ///< accel_x is alive and trusted
  bool known = false;         ///< wheels or a camera measure the speed
  bool contradicted = false;  ///< the sources contradict each other
  bool trusted = false;       ///< no wheel is distrusted, nor accel_x, and nothing is suspected
};

/// Moves the integrated speed towards the consensus, and learns the offset of the accelerometer
/// (slope and bias) from their difference.
void follow_consensus(Observations& observed, double dt, const SpeedReference& reference) noexcept;

}  // namespace odomd::estimator::integrity
