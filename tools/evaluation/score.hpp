// How much better one configuration is than another over some drives.
#pragma once

#include <array>
#include <span>

#include "tools/evaluation/evaluation.hpp"

namespace odomd::tools {

/// The errors of a replay with a reference: mean displacement error over 35 ms and over 1 s [m],
/// rms of position [m] and of heading [rad]; NaN if the drive does not determine it.
using Score = std::array<double, 4>;

[[nodiscard]] Score score_of(const Evaluation& evaluation);

/// The errors of `tried` over those of `before`: the geometric mean of the ratios over drives and
/// errors, so that no drive weighs more for being long or hard. 1: as good; 0.9: a tenth better.
/// What a drive did not determine before does not count; what it no longer determines is infinitely
/// bad.
[[nodiscard]] double relative_error(std::span<const Score> tried, std::span<const Score> before);

}  // namespace odomd::tools
