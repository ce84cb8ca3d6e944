// Judges the stamps of a log before its frames are used: a stamp that stands alone is
// distinguished from a step of the clock, and a log whose stamps are no times is refused.
//
// The clock of a log follows its frames, so that one wrong stamp ahead would make all frames after
// it too old. After a step or a pause, the frames that follow stay there; after a wrong stamp they
// come back. So a few frames are read ahead.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <string>
#include <vector>

#include "can_protocol/frame.hpp"

namespace odomd::can {

/// The frames that are read; empty: all. Of mapped messages, so that the stamps of other senders
/// and adapters move no clock.
using FrameSelection = std::function<bool(const Frame&)>;

struct LoggedFrame {
  Frame frame;
  std::uint64_t line = 0;
};

class LogStamps {
 public:
  /// Frames that are read ahead of the one that is judged.
  static constexpr std::size_t window = 32;
  /// Buses whose clocks differ by less are used together: the filter's window holds what comes late
  /// by as much.
  static constexpr std::int64_t max_ahead_ns = 200'000'000;
  static constexpr std::int64_t max_behind_ns = 1'000'000'000;

  enum class Judging : std::uint8_t {
    offline,
    live,  ///< frames are not waited for, and every stamp is taken
  };
  LogStamps(std::string label, Judging judging);

  /// Adds the next frame of the log. Throws LogError when its stamps turn out to be the time since
  /// the frame before.
  void add(const Frame& frame, std::uint64_t line_number);
  /// The log has ended. Throws as add() does.
  void end();

  /// The next frame, valid until the next call; nullptr: more frames are needed, or it has ended.
  [[nodiscard]] const LoggedFrame* next();

  [[nodiscard]] bool ended() const noexcept { return ended_; }
  [[nodiscard]] std::uint64_t frames() const noexcept { return frames_; }
  /// What is wrong with a log whose frames so far, at least so many, all have one stamp, so that no
  /// time passes; empty otherwise.
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
  std::uint64_t first_alone_ = 0;  ///< its line number
  bool ended_ = false;
};

}  // namespace odomd::can
