// How far long work is, on standard error: one line that is kept up to date on a terminal, a line
// every ten seconds elsewhere.
#pragma once

#include <chrono>
#include <functional>
#include <string>

namespace odomd::tools {

/// Told how far it is, as often as one likes.
using TellProgress = std::function<void(const std::string&)>;

class ProgressLine {
 public:
  /// `who` begins the lines that are no terminal's: "odom tune".
  explicit ProgressLine(std::string who);
  /// Ends the line.
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// On a terminal ten times a second at most.
  void show(const std::string& text);
  /// Before something else is written.
  void end();

 private:
  std::string who_;
  bool terminal_;
  bool shown_ = false;
  std::chrono::steady_clock::time_point next_;
};

}  // namespace odomd::tools
