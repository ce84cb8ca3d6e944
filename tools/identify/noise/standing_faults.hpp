// Deviations of a standing record from white noise on a walking bias: outliers, correlated samples,
// jumps.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "tools/identify/common/signal_log.hpp"
#include "tools/identify/noise/standing_noise.hpp"

namespace odomd::tools {

/// The samples farther than 6 σ from the prediction by those before. σ² is by the median of the
/// innovations (of λ, see bias_filter.hpp), and `least` at least.
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
