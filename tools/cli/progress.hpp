// Shows the progress of long work on standard error: on a terminal one line, updated and cut to its
// width; elsewhere a line every ten seconds or every second, or nothing.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>

namespace odomd::tools {

/// Called with the progress, arbitrarily often.
using ReportProgress = std::function<void(const std::string&)>;

/// How to show progress if standard error is not a terminal.
enum class WithoutTerminal : std::uint8_t { lines, every_second, nothing };

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
