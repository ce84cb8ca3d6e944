#include "tools/cli/progress.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <utility>

#include "base/printable.hpp"
#include "tools/cli/output.hpp"

namespace odomd::tools {
namespace {

using std::chrono::steady_clock;

/// A longer line would wrap, and only its last part be overwritten. Each byte counts as a column.
std::string cut_to_terminal(const std::string& text) {
  winsize size{};
  if (::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col < 2) return text;
  return shortened(text, size.ws_col - 2U);
}

}  // namespace

ProgressLine::ProgressLine(std::string who, WithoutTerminal without)
    : who_(std::move(who)),
      without_(without),
      terminal_(::isatty(STDERR_FILENO) != 0),
      interval_(terminal_                                  ? 100
                : without == WithoutTerminal::every_second ? 1'000
                                                           : 10'000),
      next_(steady_clock::now() +
            (interval_.count() < 10'000 ? std::chrono::milliseconds{} : interval_)) {}

ProgressLine::~ProgressLine() {
  end();
}

void ProgressLine::show(const std::string& text) {
  const auto now = steady_clock::now();
  if (now < next_) return;
  next_ = now + interval_;
  if (terminal_) {
    draw('\r' + cut_to_terminal(escaped(text)) + "\x1b[K");
    shown_ = true;
  } else if (without_ != WithoutTerminal::nothing) {
    say(who_ + ": " + text);
  }
}

void ProgressLine::end() {
  if (shown_) draw("\n");
  shown_ = false;
}

void ProgressLine::finish(const std::string& text) {
  next_ = {};
  show(text);
  end();
}

}  // namespace odomd::tools
