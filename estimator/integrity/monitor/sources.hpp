// What the parts of the source monitor share.
#pragma once

#include <cstddef>
#include <cstdint>

#include "estimator/common/measurement.hpp"

namespace odomd::estimator::monitor {

/// Of the sources for which is_wheel() holds.
inline constexpr std::size_t wheel_count = 6;
[[nodiscard]] constexpr Source wheel_source(std::size_t wheel) noexcept {
  return static_cast<Source>(index_of(Source::wheel_front_left) + wheel);
}

/// How often the sources are held against each other.
inline constexpr std::int64_t look_every_ns = 20'000'000;

/// Below, the car may as well stand [m/s].
inline constexpr double slowest_speed = 0.1;

/// Over so long the camera's motion is taken, at least [s].
inline constexpr double camera_span_s = 0.2;

}  // namespace odomd::estimator::monitor
