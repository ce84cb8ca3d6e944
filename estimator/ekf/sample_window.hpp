// The samples of the last fraction of a second, in the order of their own times: whatever the order
// they arrive in, the filter sees the same sequence.
//
// docs/model.md, "Late samples".
#pragma once

#include <algorithm>
#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>

#include "estimator/common/measurement.hpp"

namespace odomd::estimator::full {

/// A sample of any source. Signals use the first value and sigma; the camera has x, y, yaw.
struct Sample {
  std::int64_t time_ns = 0;
  Source source = Source::yaw_rate;
  bool judged = false;  ///< its verdict has been told
  std::array<double, 3> value{};
  std::array<double, 3> sigma{};
};

/// A total order: time, source, and, of two that claim to be the same sample, the numbers.
[[nodiscard]] inline bool operator<(const Sample& a, const Sample& b) noexcept {
  if (a.time_ns != b.time_ns) {
    return a.time_ns < b.time_ns;
  }
  if (a.source != b.source) {
    return a.source < b.source;
  }
  return a.value != b.value ? a.value < b.value : a.sigma < b.sigma;
}

/// What became of a sample that was offered to the window.
enum class Insertion : std::uint8_t { inserted, duplicate, replaced, dropped };

class SampleWindow {
 public:
  static constexpr std::size_t capacity = 1024;

  /// Puts a sample in its place. Of two with the same source and time one is kept, whichever comes
  /// first in the order above: `replaced` says that it was the one that came now; it has the
  /// verdict of the other. In a full window the oldest is given up, be it the one that came now.
  Insertion insert(const Sample& sample) noexcept;

  /// Forgets what is not later than `time_ns`, and what is.
  void forget_until(std::int64_t time_ns) noexcept { begin_ += until(time_ns).size(); }
  void forget_after(std::int64_t time_ns) noexcept { end_ -= after(time_ns).size(); }

  /// The samples not later than `time_ns`, in order, and those that are.
  [[nodiscard]] std::span<const Sample> until(std::int64_t time_ns) const noexcept;
  [[nodiscard]] std::span<Sample> after(std::int64_t time_ns) noexcept;

  /// How many of each source a full window gave up before their verdict was told, since the last
  /// call. One that insert() refused does not count: who offered it knows.
  [[nodiscard]] std::array<std::uint32_t, source_count> take_dropped() noexcept {
    return std::exchange(dropped_, {});
  }

  /// The latest time that a full window had to give up; the lowest number where none was.
  [[nodiscard]] std::int64_t dropped_until_ns() const noexcept { return dropped_until_ns_; }

 private:
  std::array<Sample, 2 * capacity> samples_{};
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::array<std::uint32_t, source_count> dropped_{};
  std::int64_t dropped_until_ns_ = std::numeric_limits<std::int64_t>::min();
};

}  // namespace odomd::estimator::full
