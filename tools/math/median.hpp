// Medians; the upper one of the middle two if the number of values is even.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace odomd::tools {

/// The median of at least one value.
template <typename T>
[[nodiscard]] T median_of(std::vector<T> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

template <typename Range>
[[nodiscard]] double median_of_magnitudes(const Range& values) {
  std::vector<double> magnitudes(values.begin(), values.end());
  for (double& value : magnitudes) value = std::fabs(value);
  return median_of(std::move(magnitudes));
}

/// The standard deviation of normal values with this median of magnitudes; 0 without values.
template <typename Range>
[[nodiscard]] double robust_sigma(const Range& values) {
  return values.begin() == values.end() ? 0.0 : 1.4826 * median_of_magnitudes(values);
}

}  // namespace odomd::tools
