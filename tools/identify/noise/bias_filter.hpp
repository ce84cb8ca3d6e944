// A Kalman filter of a sensor's bias while the car stands: y = b + v, b a random walk, v white; and
// how a record deviates from that: outliers, correlated samples, jumps.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tools/identify/common/signal_log.hpp"
#include "tools/identify/noise/standing_noise.hpp"

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

/// Appends ν/√s of all samples but the first to `innovations`, if given.
[[nodiscard]] FilteredBias filter_bias(const Series& series, double lambda, Direction direction,
                                       std::vector<double>* innovations = nullptr);

/// The samples farther than 6 σ from the prediction by those before. σ² is by the median of the
/// innovations, and `least` at least.
[[nodiscard]] std::vector<std::size_t> far_off(const Series& series, double lambda, double least);

/// The series without these samples; they are sorted.
[[nodiscard]] Series without(const Series& series, std::span<const std::size_t> samples);

/// Whether successive innovations are correlated: above 0.1, and significantly.
[[nodiscard]] bool hang_together(const Series& series, double lambda);

/// Means over every `count` samples.
[[nodiscard]] Series means_of(const Series& series, std::size_t count);

/// The mean variance of samples about the means that they make.
[[nodiscard]] double scatter_within(const Series& series, std::size_t count);

/// The largest jump: means over 1, 4 or 16 s before and after that differ by 6 sigma of noise and
/// walk [unit/√s].
[[nodiscard]] std::optional<Jump> find_jump(const Series& series, double variance, double walk);

}  // namespace odomd::tools
