// Whether a log's frames stand in the order of their stamps: where they do not, whatever reads it
// as signals over time would find no motion, or another one.
#pragma once

#include <algorithm>
#include <concepts>
#include <cstdint>
#include <string>

namespace odomd::tools {

/// Logs are in the order of their stamps but for what adapters and several buses mix up; a frame
/// this far behind is of another drive, or of a clock that was set back [ns].
inline constexpr std::int64_t late_ns = 1'000'000'000;

/// Counts the frames that are stamped late_ns or more before a frame ahead of them. Frames without
/// a stamp (0) do not count.
class LogOrder {
 public:
  /// `position` tells where the frame stands, "drive.log:12: "; asked for once at the most.
  void take(std::int64_t time_ns, const std::invocable auto& position) {
    if (time_ns <= 0) return;
    if (time_ns <= newest_ns_ - late_ns && late_++ == 0) first_late_ = position();
    newest_ns_ = std::max(newest_ns_, time_ns);
  }

  /// Throws std::invalid_argument where there was such a frame.
  void require_sorted() const;

 private:
  std::int64_t newest_ns_ = 0;
  std::uint64_t late_ = 0;
  std::string first_late_;
};

}  // namespace odomd::tools
