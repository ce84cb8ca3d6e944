// Standard output and standard error of the programs, safe against readers that stop reading; and
// the progress of long work.
//
// Commands with their own shutdown block INT and TERM (Interrupt). A write to a pipe that nobody
// empties would then block for ever: here it ends one second after the signal. Output is also made
// harmless to terminals (base/printable.hpp).
#pragma once

#include <chrono>
#include <csignal>
#include <cstdint>
#include <functional>
#include <streambuf>
#include <string>
#include <string_view>

namespace odomd::tools {

/// Whether INT, TERM or HUP is pending. It stays pending.
[[nodiscard]] bool stop_is_asked();

/// Writes everything, waiting for the reader. Returns 0, or errno; ECANCELED: a signal to stop is
/// pending and nothing could be written for a second.
[[nodiscard]] int write_all(int descriptor, std::string_view text);

/// The message for an error of write_all(), also for ECANCELED.
[[nodiscard]] std::string why_not_written(int error);

/// The buffer behind std::cout or std::cerr. A failure is permanent; errno has the reason.
class OutputBuffer final : public std::streambuf {
 public:
  explicit OutputBuffer(int descriptor);

 protected:
  int_type overflow(int_type c) override;
  std::streamsize xsputn(const char* text, std::streamsize size) override;
  int sync() override;

 private:
  int descriptor_;
  bool terminal_;
  int error_ = 0;
  std::string waiting_;
};

/// While it lives, std::cout and std::cerr write through OutputBuffers.
class StandardStreams {
 public:
  StandardStreams();
  ~StandardStreams();
  StandardStreams(const StandardStreams&) = delete;
  StandardStreams& operator=(const StandardStreams&) = delete;

 private:
  OutputBuffer out_;
  OutputBuffer error_;
  std::streambuf* out_before_;
  std::streambuf* error_before_;
};

/// Writes one line to standard error, even if the text (a file name) contains control characters.
void say(std::string_view text);

/// "odom fault: warning: ...", in the same way; `command` is "fault".
void warn(std::string_view command, std::string_view text);

/// Writes to standard error unescaped, for the characters that rewrite a line of a terminal.
void draw(std::string_view text);

/// Blocks INT and TERM while it lives, and for good after the first signal: timeout(1) sends two,
/// and the second must not interrupt the shutdown. Threads that start meanwhile inherit the block.
/// The signal stays pending, so that write_all() sees it while it waits. For use by one thread.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  /// Whether INT or TERM has come since the start.
  [[nodiscard]] bool requested();

 private:
  sigset_t signals_{};
  sigset_t before_{};
  bool requested_ = false;
};

/// Called with the progress, arbitrarily often.
using ReportProgress = std::function<void(const std::string&)>;

/// How to show progress if standard error is not a terminal.
enum class WithoutTerminal : std::uint8_t { lines, every_second, nothing };

/// Shows the progress of long work on standard error: on a terminal one line, updated and cut to
/// its width; elsewhere a line every ten seconds or every second, or nothing.
class ProgressLine {
 public:
  /// `who` is the start of each line without a terminal: "odom fault".
  explicit ProgressLine(std::string who, WithoutTerminal without = WithoutTerminal::lines);
  /// Ends the line.
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// Shows the progress; on a terminal at most ten times a second.
  void show(const std::string& text);
  /// Ends the line before other output.
  void end();
  /// Shows the final state, however recent the last update was, and ends the line.
  void finish(const std::string& text);

 private:
  std::string who_;
  WithoutTerminal without_;
  bool terminal_;
  bool shown_ = false;
  std::chrono::milliseconds interval_;
  std::chrono::steady_clock::time_point next_;
};

}  // namespace odomd::tools
