// The uncertainty from a sensor's resolution.
#pragma once

#include <span>

namespace odomd::tools {

/// The smallest difference between two values; 0 if all are equal.
[[nodiscard]] double resolution_of(std::span<const double> values);

/// Samples whose noise is smaller than their resolution q do not average it out: an uncertainty of
/// up to q/√12 of their mean remains, which grows with the share of equal samples.
[[nodiscard]] double rounding_left(std::span<const double> values, double resolution);

/// q/√12: for values evenly distributed between two steps.
[[nodiscard]] double rounding_noise(double resolution);

}  // namespace odomd::tools
