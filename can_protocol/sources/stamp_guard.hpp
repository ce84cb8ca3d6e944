// Checks whether a frame's time stamp can be trusted. A CAN controller delivers the frames of one
// identifier in order, so their stamps rise; if they do not, the clock is wrong, not the bus.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "can_protocol/frame.hpp"

namespace odomd::can {

enum class StampVerdict : std::uint8_t {
  trusted,
  zero,       ///< no stamp at all
  future,     ///< later than the drain
  backwards,  ///< earlier than the last one of the same bus and id
  repeated,   ///< equal to the last one of the same bus and id
  count
};
inline constexpr std::size_t stamp_verdict_count = static_cast<std::size_t>(StampVerdict::count);
inline constexpr std::array<std::string_view, stamp_verdict_count> stamp_verdict_names{
    "trusted", "zero", "future", "backwards", "repeated"};

/// Remembers the last stamp of each bus and identifier, in a fixed table: no allocation after
/// construction, bounded work. Identifiers beyond the table's capacity are checked for zero and
/// future only. For use by one thread.
class StampGuard {
 public:
  /// A stamp this far behind the last one means that the clock was set back: the guard restarts
  /// from it.
  static constexpr std::int64_t restart_ns = 1'000'000'000;
  /// The amount by which a stamp may be later than the drain: the resolution of a converted clock.
  static constexpr std::int64_t tolerance_ns = 1'000'000;

  StampVerdict check(const Frame& frame, std::int64_t now_ns) noexcept {
    if (frame.time_ns <= 0) return StampVerdict::zero;
    if (frame.time_ns > now_ns + tolerance_ns) return StampVerdict::future;
    Entry* entry = find(frame);
    if (entry == nullptr) return StampVerdict::trusted;
    const std::int64_t last = entry->last_ns;
    if (frame.time_ns == last) return StampVerdict::repeated;
    if (frame.time_ns < last && last - frame.time_ns < restart_ns) return StampVerdict::backwards;
    entry->last_ns = frame.time_ns;
    return StampVerdict::trusted;
  }

 private:
  static constexpr std::size_t capacity = 4096;  // a power of two
  static constexpr std::size_t max_probes = 16;

  struct Entry {
    std::uint64_t key = 0;  // 0: free; otherwise bus and identifier, plus one
    std::int64_t last_ns = 0;
  };

  Entry* find(const Frame& frame) noexcept {
    const std::uint64_t key = (std::uint64_t{frame.bus} << 32U | frame_key(frame)) + 1;
    std::size_t at = (key * 0x9E37'79B9'7F4A'7C15ULL) >> 52U;
    for (std::size_t probe = 0; probe < max_probes; ++probe, at = (at + 1) % capacity) {
      if (entries_[at].key == 0) entries_[at].key = key;
      if (entries_[at].key == key) return &entries_[at];
    }
    return nullptr;
  }

  std::array<Entry, capacity> entries_{};
};

}  // namespace odomd::can
