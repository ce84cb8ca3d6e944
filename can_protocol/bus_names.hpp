// The names of the buses, numbered in the order of their first appearance.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "can_protocol/frame.hpp"

namespace odomd::can {

/// Append-only; any thread except the beat may look up and add.
class BusNames {
 public:
  /// The index of the bus, which is added if it is new; empty when there is no room.
  std::optional<std::uint8_t> index_of(std::string_view name) {
    const std::scoped_lock lock(mutex_);
    for (std::size_t i = 0; i < count_; ++i)
      if (names_[i] == name) return static_cast<std::uint8_t>(i);
    if (count_ == max_buses) return std::nullopt;
    names_[count_] = name;
    return static_cast<std::uint8_t>(count_++);
  }

  [[nodiscard]] std::vector<std::string> all() const {
    const std::scoped_lock lock(mutex_);
    return {names_.begin(), names_.begin() + static_cast<std::ptrdiff_t>(count_)};
  }

 private:
  mutable std::mutex mutex_;
  std::array<std::string, max_buses> names_;
  std::size_t count_ = 0;
};

}  // namespace odomd::can
