// Reads the lines of a log, and sorts them into frames, lines without a frame, and damaged lines.
// Replay and daemon both use this code, so they use the same frames.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "can_protocol/bus_names.hpp"
#include "can_protocol/frame.hpp"
#include "can_protocol/sources/candump.hpp"

namespace odomd::can {

/// Reads lines from a file descriptor (a log file or a pipe), which it does not own, through one
/// fixed buffer. For use by one thread.
class LineBuffer {
 public:
  /// The maximum length of a line; a longer one is returned in pieces of this size.
  static constexpr std::size_t capacity = std::size_t{1} << 17U;

  enum class Fill : std::uint8_t { data, end, again, error };

  /// The next complete line without its newline; empty when the buffer has none. The view is valid
  /// until the next fill.
  [[nodiscard]] std::optional<std::string_view> next_line() noexcept;

  /// After the end of the input: the text after the last newline, if any.
  [[nodiscard]] std::optional<std::string_view> last_line() noexcept;

  /// Reads once. `error` leaves errno as read(2) set it; `again`: no data yet.
  Fill fill(int descriptor) noexcept;

  /// The text that has been read and not yet returned; valid until the next fill.
  [[nodiscard]] std::string_view rest() const noexcept {
    return {data_.get() + begin_, end_ - begin_};
  }

  /// The number of the line that was returned last, 1-based.
  [[nodiscard]] std::uint64_t line_number() const noexcept { return line_number_; }

 private:
  std::unique_ptr<char[]> data_ = std::make_unique<char[]>(capacity);
  std::size_t begin_ = 0;
  std::size_t scanned_ = 0;  // no newline in [begin_, scanned_)
  std::size_t end_ = 0;
  std::uint64_t line_number_ = 0;
};

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
