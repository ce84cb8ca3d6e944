// Reads candump logs offline: one log, or several merged in the order of their stamps.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/file_descriptor.hpp"
#include "can_protocol/bus_names.hpp"
#include "can_protocol/frame.hpp"
#include "can_protocol/sources/log_lines.hpp"
#include "can_protocol/sources/log_stamps.hpp"

namespace odomd::can {

/// Whether opening a FIFO waits for a writer.
enum class FifoOpening : std::uint8_t { wait_for_writer, non_blocking };

/// Opens a log for reading; "-" is standard input. Throws LogError when it is missing, a directory,
/// not readable, or a file of another format.
[[nodiscard]] FileDescriptor open_log(const std::string& path,
                                      FifoOpening fifo = FifoOpening::wait_for_writer);

/// "drive.log", or "standard input" for "-".
[[nodiscard]] std::string log_label(const std::string& path);

/// Describes a file of another tool by its first bytes, and how to convert it to a candump log: "is
/// a Vector ASC log, not a candump log; ..."; empty for a candump log and for anything unknown.
[[nodiscard]] std::optional<std::string> describe_foreign_format(std::string_view start);

/// Whether damaged lines are left out, or a log with damaged lines is refused.
enum class Damage : std::uint8_t { left_out, refused };

/// One log, frame by frame, in the file's order. For use by one thread.
class LogReader {
 public:
  /// `path` may be "-", standard input. `buses` numbers the interfaces and must outlive this.
  /// Throws LogError as open_log does.
  LogReader(const std::string& path, BusNames& buses, Damage damage = Damage::left_out);

  /// The next frame with its time on the log's clock, valid until the next call; nullptr at the
  /// end. Throws LogError at a damaged line that is refused, at one bus too many, and at the end of
  /// a log without frames; std::system_error when reading fails. A truncated last line (no newline,
  /// no frame) ends the log with a warning.
  [[nodiscard]] const Frame* next();

  /// One warning for each kind of lines without a frame.
  [[nodiscard]] std::vector<std::string> warnings() const { return lines_.warnings(); }
  [[nodiscard]] const std::string& label() const noexcept { return label_; }
  [[nodiscard]] std::uint64_t line_number() const noexcept { return buffer_.line_number(); }
  [[nodiscard]] std::uint64_t frames() const noexcept { return lines_.frames(); }

 private:
  bool take(std::string_view text, LineEnd end);

  std::string label_;
  Damage damage_;
  FileDescriptor file_;
  LineBuffer buffer_;
  LogLines lines_;
  Frame frame_;
  bool ended_ = false;
};

/// Merges several logs in the order of their stamps; if stamps are equal, the log named first comes
/// first. A log whose stamps go backwards keeps its own order. Frames whose stamps stand alone are
/// left out. For use by one thread.
class MergedLog {
 public:
  /// Only `selected` frames are returned, and only their stamps count. Throws as LogReader does,
  /// also for logs without frames, and for logs in which no time passes or whose stamps are the
  /// time since the previous frame.
  MergedLog(std::span<const std::string> paths, BusNames& buses, FrameSelection selected = {},
            Damage damage = Damage::left_out);

  /// See LogReader::next().
  [[nodiscard]] const Frame* next();

  /// "drive.log:12: ", the position of the newest frame; empty before the first and at the end.
  [[nodiscard]] std::string position() const;

  /// The warnings so far, in the order in which the logs were named.
  [[nodiscard]] std::vector<std::string> warnings() const;

 private:
  struct Input {
    LogReader reader;
    LogStamps stamps;
    const LoggedFrame* head = nullptr;  ///< read, but not yet returned; nullptr at the end
  };
  [[nodiscard]] const LoggedFrame* read(Input& input) const;

  FrameSelection selected_;
  std::vector<Input> inputs_;
  Input* newest_ = nullptr;  ///< its head is the frame that was returned last
};

}  // namespace odomd::can
