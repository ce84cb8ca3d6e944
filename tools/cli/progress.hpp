// The progress of long work on standard error: one line that is updated on a terminal and cut to
// its width, a line every ten seconds or every second elsewhere, or nothing.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>

namespace odomd::tools {

/// Called with the progress, as often as one likes.
using ReportProgress = std::function<void(const std::string&)>;

/// What becomes of the progress where standard error is no terminal.
enum class WithoutTerminal : std::uint8_t { lines, every_second, nothing };

class ProgressLine {
 public:
  /// `who` is the start of each line without a terminal: "odom fault".
  explicit ProgressLine(std::string who, WithoutTerminal without = WithoutTerminal::lines);
  /// Ends the line.
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// On a terminal at most ten times a second.
  void show(const std::string& text);
  /// Before something else is written.
  void end();
  /// Shows the last state, whenever the one before was shown, and ends.
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
