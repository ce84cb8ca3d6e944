// A histogram of the beat as rows of block characters.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <odom/types.h>

#include "tools/live/watch/line.hpp"

namespace odomd::watch {

using Histogram = std::span<const std::uint64_t, ODOM_HISTOGRAM_BUCKETS>;

/// One column for each `buckets_a_column` buckets, `rows` rows, the topmost first. Heights are
/// logarithmic, so that one late tick in a million is seen: any bucket that is not empty has at
/// least the lowest mark, the fullest reaches the top.
[[nodiscard]] std::vector<std::string> bars(Histogram histogram, std::size_t buckets_a_column,
                                            std::size_t rows, Glyphs glyphs);

/// The axis below: where 1 us, 10, 100, 1 ms and 10 ms lie.
[[nodiscard]] std::string axis(std::size_t buckets_a_column, Glyphs glyphs);

}  // namespace odomd::watch
