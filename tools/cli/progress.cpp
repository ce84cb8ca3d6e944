#include "tools/cli/progress.hpp"

#include <unistd.h>

#include <utility>

#include "base/printable.hpp"
#include "tools/cli/output.hpp"

namespace odomd::tools {
namespace {

using std::chrono::steady_clock;

}  // namespace

ProgressLine::ProgressLine(std::string who)
    : who_(std::move(who)),
      terminal_(::isatty(STDERR_FILENO) != 0),
      next_(steady_clock::now() + std::chrono::seconds(terminal_ ? 0 : 10)) {}

ProgressLine::~ProgressLine() {
  end();
}

void ProgressLine::show(const std::string& text) {
  const auto now = steady_clock::now();
  if (now < next_) return;
  next_ = now + (terminal_ ? std::chrono::milliseconds(100) : std::chrono::seconds(10));
  if (terminal_) {
    draw('\r' + escaped(text) + "\x1b[K");
    shown_ = true;
  } else {
    say(who_ + ": " + text);
  }
}

void ProgressLine::end() {
  if (shown_) draw("\n");
  shown_ = false;
}

}  // namespace odomd::tools
