// Rotates the samples of an accelerometer that is mounted with a yaw angle into the car's axes.
#pragma once

#include <span>

#include "can_protocol/decode/decoder.hpp"

namespace odomd::daemon {

/// Rotates the accelerations of one frame by `yaw`, the angle [rad] from the car's x axis to the
/// sensor's, counter-clockwise:
///   a_x = m_x cos yaw - m_y sin yaw,  a_y = m_x sin yaw + m_y cos yaw
/// A frame needs both accelerations: a single one becomes NaN, which every filter rejects as
/// non-finite.
void turn_accelerations(std::span<can::Sample> samples, double yaw) noexcept;

}  // namespace odomd::daemon
