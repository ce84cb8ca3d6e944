// The speed by integrating the measured acceleration.
//
// docs/model.md, "Integrity".
#pragma once

#include "estimator/integrity/parity.hpp"

namespace odomd::estimator::integrity {

/// Integrates the measured acceleration over `dt` [s], unless accel_x is silent or distrusted.
/// Stops once the car stands, while all wheels are distrusted.
void integrate_acceleration(const Sensors& sensors, Observations& observed, double dt,
                            bool wheels_distrusted) noexcept;

/// Moves the integrated speed towards the consensus, unless both contradict each other or the
/// consensus is `contradicted`. Learns the offset of the accelerometer (slope and bias) from their
/// difference if `learns`. Call it while wheels or a camera measure the speed.
void follow_consensus(Observations& observed, double dt, bool contradicted, bool learns) noexcept;

}  // namespace odomd::estimator::integrity
