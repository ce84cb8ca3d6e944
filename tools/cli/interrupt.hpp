// Makes INT and TERM something to poll for, so that files are closed and summaries written.
#pragma once

#include <csignal>

namespace odomd::tools {

/// Blocks INT and TERM while it lives, and for good after the first one: timeout(1) sends two, and
/// the second must not interrupt the shutdown. Threads that start meanwhile inherit this. The
/// signal stays pending, so that a write that waits for its reader finds it too (output.hpp). One
/// thread.
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
