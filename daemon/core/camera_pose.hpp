// Converts camera poses from the camera's reference point to the centre of gravity.
#pragma once

#include <array>

#include "estimator/common/measurement.hpp"

namespace odomd::daemon {

/// Moves a pose of the reference point to the centre of gravity. `lever_arm` is the reference
/// point's pose in the body frame (x, y [m], yaw [rad]). Through the lever arm, the uncertainty of
/// the yaw adds to the position's.
[[nodiscard]] estimator::CameraPose to_centre_of_gravity(
    const estimator::CameraPose& reference, const std::array<double, 3>& lever_arm) noexcept;

}  // namespace odomd::daemon
