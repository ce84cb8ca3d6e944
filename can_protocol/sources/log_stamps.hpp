// Judges the stamps of a log before its frames are used: a stamp that stands alone is
// distinguished from a step of the clock, and a log whose stamps are not times is refused.
//
// The clock of a log follows its frames, so one wrong stamp ahead would make all later frames too
// old. After a step or a pause, the next stamps stay at the new time; after a single wrong stamp
// they return to the old one. So a few frames are read ahead.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <string>
#include <vector>

#include "can_protocol/frame.hpp"

namespace odomd::can {

/// Whether to read a frame; empty: read all. It selects mapped messages, so that the stamps of
/// other senders and adapters do not move the clock.
using FrameSelection = std::function<bool(const Frame&)>;

struct LoggedFrame {
  Frame frame;
  std::uint64_t line = 0;
};

class LogStamps {
 public:
  /// Number of frames that are read ahead of the frame being judged.
  static constexpr std::size_t window = 32;
  /// Buses whose clocks differ by less than this are used together: the filter's window accepts
  /// samples that late.
  static constexpr std::int64_t max_ahead_ns = 200'000'000;
  static constexpr std::int64_t max_behind_ns = 1'000'000'000;

  enum class Judging : std::uint8_t {
    offline,
    live,  ///< does not wait for further frames, and accepts every stamp
  };
  LogStamps(std::string label, Judging judging);

  /// Adds the next frame of the log. Throws LogError when the log's stamps turn out to be times
  /// since the previous frame.
  void add(const Frame& frame, std::uint64_t line_number);
  /// The log has ended. Throws as add() does.
  void end();

  /// The next frame, valid until the next call; nullptr: more frames are needed, or the log ended.
  [[nodiscard]] const LoggedFrame* next();

  [[nodiscard]] bool ended() const noexcept { return ended_; }
  [[nodiscard]] std::uint64_t frames() const noexcept { return frames_; }
  /// The problem if all frames so far (at least `min_frames`) have the same stamp, so that no time
  /// passes; empty otherwise.
  [[nodiscard]] std::string describe_one_stamp(std::uint64_t min_frames) const;
  /// Empty, or one line about the frames that were left out.
  [[nodiscard]] std::string warning() const;

 private:
  static constexpr std::size_t enough_for_deltas = 256;
  void refuse_deltas() const;
  [[nodiscard]] bool stands_alone(std::int64_t stamp_ns) const;

  std::string label_;
  Judging judging_;
  std::deque<LoggedFrame> ahead_;
  std::deque<std::int64_t> before_;  ///< stamps of the last frames, the newest last
  LoggedFrame current_;
  std::vector<std::int64_t> first_stamps_;
  std::uint64_t frames_ = 0;
  std::uint64_t with_one_stamp_ = 0;
  std::int64_t last_stamp_ns_ = 0;
  std::uint64_t last_line_ = 0;
  std::uint64_t alone_ = 0;
  std::uint64_t first_alone_ = 0;  ///< line number of the first stamp that stands alone
  bool ended_ = false;
};

}  // namespace odomd::can
