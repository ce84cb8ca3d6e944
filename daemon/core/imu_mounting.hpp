// An accelerometer that is turned about the vertical axis against the car, and its samples in the
// car's axes.
#pragma once

#include <span>

#include "can_protocol/decode/decoder.hpp"

namespace odomd::daemon {

/// Turns the accelerations of one frame by `yaw`, the angle [rad] of the sensor's x axis in the
/// car's, counter-clockwise:
///   a_x = m_x cos yaw - m_y sin yaw,  a_y = m_x sin yaw + m_y cos yaw
/// Both axes are needed, of one instant: one that came without the other becomes NaN, which every
/// filter refuses as non-finite.
void turn_accelerations(std::span<can::Sample> samples, double yaw) noexcept;

}  // namespace odomd::daemon
