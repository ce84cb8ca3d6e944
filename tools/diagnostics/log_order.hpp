// Checks that a log's frames are in the order of their stamps: otherwise signals over time would
// show a wrong motion.
#pragma once

#include <algorithm>
#include <concepts>
#include <cstdint>
#include <stdexcept>
#include <string>

#include "daemon/diagnostics/diagnostic.hpp"

namespace odomd::tools {

/// Adapters and several buses may mix up the order a little; a frame that is late by this much
/// belongs to another drive or to a clock that was set back [ns].
inline constexpr auto late_ns =
    static_cast<std::int64_t>(1e9 * diagnostics::kind("frames_late").limits.most);

/// Counts the frames whose stamp is late_ns or more before that of a previous frame. Frames without
/// a stamp (0) do not count.
class LogOrder {
 public:
  /// `position` returns the frame's place, "drive.log:12: "; it is called once at most.
  void take(std::int64_t time_ns, const std::invocable auto& position) {
    if (time_ns <= 0) return;
    if (time_ns <= newest_ns_ - late_ns && late_++ == 0) first_late_ = position();
    newest_ns_ = std::max(newest_ns_, time_ns);
  }

  /// Throws std::invalid_argument if a frame was late.
  void require_sorted() const {
    if (late_ == 0) return;
    throw std::invalid_argument(
        first_late_ +
        (late_ == 1 ? "this frame has a stamp a second or more earlier than one before it"
                    : "from here on " + std::to_string(late_) +
                          " frames have stamps a second or more earlier than frames before them") +
        "; sort the log (tac turns one in reverse), or cut it where its clock was set back");
  }

 private:
  std::int64_t newest_ns_ = 0;
  std::uint64_t late_ = 0;
  std::string first_late_;
};

}  // namespace odomd::tools
