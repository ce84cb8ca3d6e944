// Removes the effect of a sensor's mounting from its samples: the camera's reference point, and the
// yaw of an accelerometer.
#pragma once

#include <array>
#include <span>

#include "can_protocol/decode/decoder.hpp"
#include "estimator/common/measurement.hpp"

namespace odomd::daemon {

/// Moves a pose of the reference point to the centre of gravity. `lever_arm` is the reference
/// point's pose in the body frame (x, y [m], yaw [rad]). Through the lever arm, the uncertainty of
/// the yaw adds to that of the position.
[[nodiscard]] estimator::CameraPose to_centre_of_gravity(
    const estimator::CameraPose& reference, const std::array<double, 3>& lever_arm) noexcept;

/// Rotates the accelerations of one frame by `yaw`, the angle [rad] from the car's x axis to the
/// sensor's, counter-clockwise:
///   a_x = m_x cos yaw - m_y sin yaw,  a_y = m_x sin yaw + m_y cos yaw
/// A frame needs both accelerations: a single one becomes NaN, which every filter rejects as
/// non-finite.
void turn_accelerations(std::span<can::Sample> samples, double yaw) noexcept;

}  // namespace odomd::daemon
