// A value with its uncertainty, and the uncertainty from a sensor's resolution.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <span>
#include <vector>

namespace odomd::tools {

/// A measured value and its standard uncertainty, in one unit.
struct Measured {
  double value = 0.0;
  double sigma = 0.0;
};

/// The mean of at least two values; its uncertainty comes from their scatter.
[[nodiscard]] inline Measured mean_of(std::span<const double> values) {
  const auto n = static_cast<double>(values.size());
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  double squares = 0.0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return {mean, std::sqrt(squares / ((n - 1.0) * n))};
}

/// The smallest difference between two values; 0 if all are equal.
[[nodiscard]] inline double resolution_of(std::span<const double> values) {
  constexpr double arithmetic = 1e-9;  // smaller differences come from arithmetic
  std::vector<double> sorted(values.begin(), values.end());
  std::ranges::sort(sorted);
  double resolution = 0.0;
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    const double difference = sorted[i] - sorted[i - 1];
    if (difference > arithmetic && (resolution == 0.0 || difference < resolution))
      resolution = difference;
  }
  return resolution;
}

/// q/√12: for values that are evenly distributed between two steps.
[[nodiscard]] inline double rounding_noise(double resolution) {
  return resolution / std::sqrt(12.0);
}

/// If the noise is smaller than the resolution q, rounding errors do not average out: the mean has
/// an uncertainty of up to q/√12, which grows with the share of the most frequent value.
[[nodiscard]] inline double rounding_left(std::span<const double> values, double resolution) {
  std::vector<double> sorted(values.begin(), values.end());
  std::ranges::sort(sorted);
  std::size_t most = 0, count = 0;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    count = i > 0 && sorted[i] == sorted[i - 1] ? count + 1 : 1;
    most = std::max(most, count);
  }
  if (most == 0) return 0.0;
  const double same = static_cast<double>(most) / static_cast<double>(sorted.size());
  return rounding_noise(resolution) * std::max(0.0, 2.0 * same - 1.0);
}

}  // namespace odomd::tools
