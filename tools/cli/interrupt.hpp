// INT and TERM as a question instead of an end, so that files are closed and summaries written.
#pragma once

#include <csignal>

namespace odomd::tools {

/// Holds INT and TERM back while it lives, and from the first one on: timeout(1) sends two, and the
/// second must not cut the end short. Threads that start meanwhile inherit this. The signal stays
/// pending, so that a write that waits for its reader finds it too (output.hpp). One thread.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  /// Whether one of them has come since the start.
  [[nodiscard]] bool requested();

 private:
  sigset_t signals_{};
  sigset_t before_{};
  bool requested_ = false;
};

}  // namespace odomd::tools
