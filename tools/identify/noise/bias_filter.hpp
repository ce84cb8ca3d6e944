// A Kalman filter of a sensor's bias while the car stands: y = b + v, b a random walk, v white.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "tools/identify/common/signal_log.hpp"

namespace odomd::tools {

/// In units of the white noise's variance r: with λ = K²/r the bias grows by λ dt between samples,
/// and the innovations' variances are r s.
struct FilteredBias {
  double log_sum = 0.0;   ///< Σ ln s
  double squares = 0.0;   ///< Σ ν²/s
  double bias = 0.0;      ///< after the last sample
  double variance = 0.0;  ///< ... over r
};

enum class Direction : std::uint8_t { forwards, backwards };

/// take(ν, s, filter) is called for all samples but the first.
template <typename Take>
FilteredBias run_bias_filter(const Series& series, double lambda, Direction direction,
                             Take&& take) {
  const std::size_t n = series.size();
  const auto at = [&](std::size_t i) { return direction == Direction::forwards ? i : n - 1 - i; };
  FilteredBias f;
  f.bias = series.value[at(0)];
  f.variance = 1.0;
  for (std::size_t i = 1; i < n; ++i) {
    const double dt =
        1e-9 * std::fabs(static_cast<double>(series.t_ns[at(i)] - series.t_ns[at(i - 1)]));
    f.variance += lambda * dt;
    const double s = f.variance + 1.0;
    const double innovation = series.value[at(i)] - f.bias;
    take(innovation, s, f);
    f.bias += f.variance / s * innovation;
    f.variance /= s;
  }
  return f;
}

[[nodiscard]] inline FilteredBias filter_bias(const Series& series, double lambda,
                                              Direction direction) {
  return run_bias_filter(series, lambda, direction,
                         [](double innovation, double s, FilteredBias& f) {
                           f.log_sum += std::log(s);
                           f.squares += innovation * innovation / s;
                         });
}

/// ν/√s of all samples but the first.
[[nodiscard]] inline std::vector<double> innovations(const Series& series, double lambda) {
  std::vector<double> all;
  all.reserve(series.size());
  (void)run_bias_filter(series, lambda, Direction::forwards,
                        [&all](double innovation, double s, const FilteredBias&) {
                          all.push_back(innovation / std::sqrt(s));
                        });
  return all;
}

}  // namespace odomd::tools
