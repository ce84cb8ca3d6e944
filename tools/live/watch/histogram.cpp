#include "tools/live/watch/histogram.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string_view>

#include "tools/cli/text.hpp"

namespace odomd::watch {
namespace {

using Levels = std::array<std::string_view, 9>;
constexpr Levels blocks{" ", "▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
constexpr Levels letters{" ", ".", ":", "-", "=", "+", "*", "%", "#"};

// How many levels high a column is.
std::size_t height(std::uint64_t count, std::uint64_t largest, std::size_t levels) {
  if (count == 0) return 0;
  const double share =
      std::log1p(static_cast<double>(count)) / std::log1p(static_cast<double>(largest));
  const auto level = static_cast<std::size_t>(std::lround(share * static_cast<double>(levels)));
  return std::clamp<std::size_t>(level, 1, levels);
}

// The column of a time: bucket i >= 1 begins at 2^((i-1)/4) us.
std::size_t column_of(double us, std::size_t buckets_a_column) {
  const auto bucket = 1 + static_cast<std::size_t>(std::floor(4.0 * std::log2(us) + 1e-9));
  return bucket / buckets_a_column;
}

}  // namespace

std::vector<std::string> bars(Histogram histogram, std::size_t buckets_a_column, std::size_t rows,
                              Glyphs glyphs) {
  const Levels& marks = glyphs == Glyphs::unicode ? blocks : letters;
  constexpr std::size_t marks_a_row = blocks.size() - 1;

  std::vector<std::uint64_t> counts;
  for (std::size_t i = 0; i < histogram.size(); i += buckets_a_column) {
    const auto part = histogram.subspan(i, std::min(buckets_a_column, histogram.size() - i));
    counts.push_back(std::accumulate(part.begin(), part.end(), std::uint64_t{0}));
  }
  const std::uint64_t largest = *std::max_element(counts.begin(), counts.end());

  std::vector<std::string> lines(rows);
  for (const std::uint64_t count : counts) {
    const std::size_t level = height(count, largest, rows * marks_a_row);
    for (std::size_t row = 0; row < rows; ++row) {
      const std::size_t below = (rows - 1 - row) * marks_a_row;
      lines[row] += marks[level > below ? std::min(level - below, marks_a_row) : 0];
    }
  }
  return lines;
}

std::string axis(std::size_t buckets_a_column, Glyphs glyphs) {
  const std::string_view micro = glyphs == Glyphs::unicode ? "1 µs" : "1 us";
  std::string line;
  for (const auto& [us, label] :
       {std::pair{1.0, micro}, std::pair{10.0, std::string_view{"10"}},
        std::pair{100.0, std::string_view{"100"}}, std::pair{1e3, std::string_view{"1 ms"}},
        std::pair{1e4, std::string_view{"10 ms"}}}) {
    const std::size_t column = column_of(us, buckets_a_column);
    line.append(column - std::min(column, tools::width(line)), ' ');
    line += label;
  }
  return line;
}

}  // namespace odomd::watch
