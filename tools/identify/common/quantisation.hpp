// What the steps in which a sensor's samples come leave uncertain.
#pragma once

#include <span>

namespace odomd::tools {

/// The smallest difference between two values; 0 where all are the same.
[[nodiscard]] double resolution_of(std::span<const double> values);

/// Samples whose noise is smaller than their resolution q do not average it out: of their mean up
/// to q/√12 remains uncertain, the more the more of them are the same.
[[nodiscard]] double rounding_left(std::span<const double> values, double resolution);

/// q/√12: of values that lie anywhere between two steps.
[[nodiscard]] double rounding_noise(double resolution);

}  // namespace odomd::tools
