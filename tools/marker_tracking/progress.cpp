#include "tools/marker_tracking/progress.hpp"

#include <unistd.h>

#include <fmt/format.h>

#include "tools/cli/output.hpp"

namespace odomd::tools {

FrameProgress::FrameProgress(bool always) : shown_(always || ::isatty(STDERR_FILENO) != 0) {}

FrameProgress::~FrameProgress() {
  if (drawn_) draw("\n");
}

void FrameProgress::update(std::int64_t frame, std::int64_t total, std::int64_t found) {
  if (!shown_ || (frame % 25 != 0 && frame != total)) return;
  drawn_ = true;
  const std::string of = total > 0 ? fmt::format(" of {}", total) : "";
  draw(fmt::format("\rframe {}{}, both markers in {}   ", frame, of, found));
}

}  // namespace odomd::tools
