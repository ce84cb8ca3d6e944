// What keeps a standing record from being white noise on a bias that walks: samples far off,
// samples that hang together, a level that jumps.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "tools/identify/common/signal_log.hpp"
#include "tools/identify/noise/standing_noise.hpp"

namespace odomd::tools {

/// The samples farther than 6 σ from what the ones before say. σ² is by the median of the
/// innovations (of λ, see bias_filter.hpp), and `least` at least.
[[nodiscard]] std::vector<std::size_t> far_off(const Series& series, double lambda, double least);

/// The series without these samples; they are sorted.
[[nodiscard]] Series without(const Series& series, std::span<const std::size_t> samples);

/// Whether an innovation tells the next one: a correlation above 0.1, and no chance.
[[nodiscard]] bool hang_together(const Series& series, double lambda);

/// Means over every `count` samples.
[[nodiscard]] Series means_of(const Series& series, std::size_t count);

/// The mean variance of samples about the means that they make.
[[nodiscard]] double scatter_within(const Series& series, std::size_t count);

/// The farthest jump, where the means over 1, 4 or 16 s before and after differ by 6 times what
/// noise and walk [unit/√s] make of it.
[[nodiscard]] std::optional<Jump> find_jump(const Series& series, double variance, double walk);

}  // namespace odomd::tools
