// Warnings of a source about its input: the first of each kind, so that a malformed line does not
// hide a later warning about the clock.
#pragma once

#include <array>
#include <atomic>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace odomd::can {

enum class SourceWarning : std::uint8_t {
  malformed_line,
  damaged_line,
  foreign_format,
  too_many_buses,
  one_stamp,
  lone_stamps,
  long_pause,
  earlier_lines,
  later_lines,
  clock_step,
  small_buffer,
  failure,
};

/// One thread adds warnings; another may list them meanwhile.
class SourceWarnings {
 public:
  void add(SourceWarning kind, std::string text) {
    const auto index = static_cast<std::size_t>(kind);
    if (said_.test(index)) return;
    said_.set(index);
    const std::size_t count = count_.load(std::memory_order_relaxed);
    texts_.at(count) = std::move(text);
    count_.store(count + 1, std::memory_order_release);
  }

  /// In the order of their occurrence; the list only grows.
  [[nodiscard]] std::vector<std::string> list() const {
    const std::size_t count = count_.load(std::memory_order_acquire);
    return {texts_.begin(), texts_.begin() + static_cast<std::ptrdiff_t>(count)};
  }

 private:
  static constexpr std::size_t kinds = static_cast<std::size_t>(SourceWarning::failure) + 1;

  std::bitset<kinds> said_;               // used by the adding thread only
  std::array<std::string, kinds> texts_;  // each written once, before the count
  std::atomic<std::size_t> count_{0};
};

}  // namespace odomd::can
