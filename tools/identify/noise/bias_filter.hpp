// A Kalman filter of a sensor's bias while the car stands: y = b + v, b a random walk, v white.
#pragma once

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

[[nodiscard]] FilteredBias filter_bias(const Series& series, double lambda, Direction direction);

/// ν/√s of all samples but the first.
[[nodiscard]] std::vector<double> innovations(const Series& series, double lambda);

}  // namespace odomd::tools
