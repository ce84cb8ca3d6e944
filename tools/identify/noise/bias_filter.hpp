// A Kalman filter for a sensor's bias while the car is at rest: y = b + v, b a random walk, v
// white; and deviations of a record from that model: outliers, correlated samples.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tools/identify/common/signal_log.hpp"

namespace odomd::tools {

/// Variances are in units of the white noise's variance r: with λ = K²/r the bias's variance grows
/// by λ dt between samples, and the innovations' variances are r s.
struct FilteredBias {
  double log_sum = 0.0;   ///< Σ ln s
  double squares = 0.0;   ///< Σ ν²/s
  double bias = 0.0;      ///< after the last sample
  double variance = 0.0;  ///< its variance over r
};

enum class Direction : std::uint8_t { forwards, backwards };

/// Appends ν/√s of each sample but the first to `innovations`, if given.
[[nodiscard]] FilteredBias filter_bias(const Series& series, double lambda, Direction direction,
                                       std::vector<double>* innovations = nullptr);

/// The samples more than 6 σ from the prediction. σ comes from the median of the innovations, and
/// is at least `least`.
[[nodiscard]] std::vector<std::size_t> far_off(const Series& series, double lambda, double least);

/// The series without the samples with these sorted indices.
[[nodiscard]] Series without(const Series& series, std::span<const std::size_t> samples);

/// Whether successive innovations are significantly correlated, by more than 0.1.
[[nodiscard]] bool are_correlated(const Series& series, double lambda);

/// Means over every `count` samples.
[[nodiscard]] Series means_of(const Series& series, std::size_t count);

/// The mean variance of samples about the mean of their group of `count`.
[[nodiscard]] double scatter_within(const Series& series, std::size_t count);

}  // namespace odomd::tools
