// What a source tells the user of its input: of each kind the first, so that a broken line does not
// hide what is said later of the clock.
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

enum class Complaint : std::uint8_t {
  malformed_line,
  too_many_buses,
  one_stamp,
  long_pause,
  late_first_line,
  clock_step,
  small_buffer,
  failure,
};

/// One thread adds, another may list meanwhile.
class Complaints {
 public:
  void add(Complaint kind, std::string text) {
    const auto index = static_cast<std::size_t>(kind);
    if (said_.test(index)) return;
    said_.set(index);
    const std::size_t count = count_.load(std::memory_order_relaxed);
    texts_.at(count) = std::move(text);
    count_.store(count + 1, std::memory_order_release);
  }

  /// In the order in which they came; it only grows.
  [[nodiscard]] std::vector<std::string> list() const {
    const std::size_t count = count_.load(std::memory_order_acquire);
    return {texts_.begin(), texts_.begin() + static_cast<std::ptrdiff_t>(count)};
  }

 private:
  static constexpr std::size_t kinds = static_cast<std::size_t>(Complaint::failure) + 1;

  std::bitset<kinds> said_;               // who adds, alone
  std::array<std::string, kinds> texts_;  // each written once, before the count
  std::atomic<std::size_t> count_{0};
};

}  // namespace odomd::can
