// Sorts the lines of a log into frames, lines without a frame, and damaged lines. Replay and daemon
// both use it, and so use the same frames.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "can_protocol/bus_names.hpp"
#include "can_protocol/frame.hpp"
#include "can_protocol/sources/candump.hpp"

namespace odomd::can {

/// A log that cannot be used: one line that names the file, the line and the fix.
class LogError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

enum class LineKind : std::uint8_t {
  frame,
  blank,
  passed_over,  ///< no frame for canplayer: a comment, candump's DROPCOUNT, CAN XL
  damaged,      ///< a part of a frame, or bytes that no text has
  cut_off,      ///< a part of a frame at the end of the log
  bus_too_many,
};

enum class LineEnd : std::uint8_t { newline, end_of_log };

/// The lines of one log, in order. For use by one thread.
class LogLines {
 public:
  /// `label` names the log in messages. `buses` numbers the interfaces and must outlive this.
  LogLines(std::string label, BusNames& buses);

  /// Reads the next line, without its newline, and sets `frame` if it has a frame.
  LineKind read(std::string_view text, std::uint64_t line_number, LineEnd end, Frame& frame);

  /// The problem of the line just read, which must not be a frame.
  [[nodiscard]] std::string problem() const;

  [[nodiscard]] std::uint64_t frames() const noexcept { return frames_; }
  /// The problem of the first line that is neither blank nor a frame; empty: there was none.
  [[nodiscard]] const std::string& first_problem() const noexcept { return first_problem_; }
  /// One warning each about the lines that were passed over, the damaged ones, and the cut-off one.
  [[nodiscard]] std::vector<std::string> warnings() const;

 private:
  struct Tally {
    std::uint64_t lines = 0;
    std::uint64_t stretches = 0;
    std::uint64_t first = 0;  ///< line numbers
    std::uint64_t last = 0;
  };
  LineKind classify(std::string_view text, Frame& frame);
  static void count(Tally& tally, std::uint64_t line_number);

  std::string label_;
  BusNames& buses_;
  std::string last_interface_;  // avoids the look-up in the common case
  std::uint8_t last_bus_ = 0;
  std::uint64_t frames_ = 0;

  // The line just read.
  std::string_view text_;
  std::uint64_t number_ = 0;
  LineKind kind_ = LineKind::blank;
  CandumpLine parsed_;

  Tally passed_over_;
  Tally damaged_;
  std::string first_passed_over_;
  std::string first_problem_;
  std::string cut_off_;
};

/// "drive.log:12: ", the place of a message.
[[nodiscard]] std::string at_line(const std::string& label, std::uint64_t line_number);

}  // namespace odomd::can
