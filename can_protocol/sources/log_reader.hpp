// Reads candump logs offline: one log, or several merged in the order of their stamps.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/file_descriptor.hpp"
#include "can_protocol/bus_names.hpp"
#include "can_protocol/frame.hpp"
#include "can_protocol/sources/candump.hpp"
#include "can_protocol/sources/line_buffer.hpp"

namespace odomd::can {

/// A log that cannot be used: one line that names the file, the line and the fix.
class LogError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// Whether opening a FIFO waits for a writer.
enum class FifoOpening : std::uint8_t { wait_for_writer, at_once };

/// Opens a log for reading; "-" is standard input. Throws LogError when it is missing, a directory,
/// or not readable.
[[nodiscard]] FileDescriptor open_log(const std::string& path,
                                      FifoOpening fifo = FifoOpening::wait_for_writer);

/// "drive.log", or "standard input" for "-".
[[nodiscard]] std::string log_label(const std::string& path);

/// The error for a log in which no time passes; `position`, "drive.log:150: ", is that of its last
/// frame.
[[nodiscard]] std::string describe_one_stamp(const std::string& position, std::uint64_t frames,
                                             std::int64_t stamp_ns);

// Errors about a line, in one line: label, line number, problem, fix.
[[nodiscard]] std::string at_line(const std::string& label, std::uint64_t line_number);
[[nodiscard]] std::string describe(const std::string& label, std::uint64_t line_number,
                                   const CandumpLine& line);
[[nodiscard]] std::string describe_cut_off(const std::string& label, std::uint64_t line_number);
[[nodiscard]] std::string describe_bus_too_many(const std::string& label, std::uint64_t line_number,
                                                std::string_view interface);

/// Whether the line has only spaces; such lines are skipped.
[[nodiscard]] bool is_blank(std::string_view line) noexcept;

/// One log, frame by frame, in the file's order. One thread.
class LogReader {
 public:
  /// `path` may be "-", standard input. Interfaces are numbered by `buses`, which must outlive
  /// this. Throws LogError as open_log does.
  LogReader(const std::string& path, BusNames& buses);

  /// The next frame with its time on the log's clock, valid until the next call; nullptr at the
  /// end. Throws LogError at a line that is not a frame, at one bus too many, and at the end of a
  /// log without frames; std::system_error when reading fails. A truncated last line (no newline,
  /// no frame) ends the log with a warning.
  [[nodiscard]] const Frame* next();

  /// Empty, or one line about what was skipped.
  [[nodiscard]] const std::string& warning() const noexcept { return warning_; }
  [[nodiscard]] const std::string& label() const noexcept { return label_; }
  [[nodiscard]] std::uint64_t line_number() const noexcept { return lines_.line_number(); }

 private:
  enum class Ending : std::uint8_t { newline, cut_off };
  bool take(std::string_view text, Ending ending);

  std::string label_;
  BusNames& buses_;
  FileDescriptor file_;
  LineBuffer lines_;
  std::string last_interface_;  // avoids the look-up in the common case
  std::uint8_t last_bus_ = 0;
  Frame frame_;
  std::uint64_t frames_ = 0;
  bool ended_ = false;
  std::string warning_;
};

/// Several logs as one, in the order of their stamps; equal stamps in the order of naming. A log
/// whose stamps go backwards keeps its own order. One thread.
class MergedLog {
 public:
  /// Throws as LogReader does, also for logs without frames.
  MergedLog(std::span<const std::string> paths, BusNames& buses);

  /// As LogReader does.
  [[nodiscard]] const Frame* next();

  /// "drive.log:12: ", the position of the newest frame; empty before the first.
  [[nodiscard]] std::string position() const;

  /// The warnings so far, in the order of naming.
  [[nodiscard]] std::vector<std::string> warnings() const;

 private:
  struct Input {
    LogReader reader;
    const Frame* head = nullptr;  ///< read, but not yet returned; nullptr at the end
  };

  std::vector<Input> inputs_;
  Input* newest_ = nullptr;  ///< its head is the frame that was returned last
};

}  // namespace odomd::can
