#include "tools/cli/interrupt.hpp"

namespace odomd::tools {

Interrupt::Interrupt() {
  sigemptyset(&signals_);
  sigaddset(&signals_, SIGINT);
  sigaddset(&signals_, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals_, &before_);
}

Interrupt::~Interrupt() {
  if (!requested()) pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

bool Interrupt::requested() {
  sigset_t pending;
  sigemptyset(&pending);
  sigpending(&pending);
  requested_ =
      requested_ || sigismember(&pending, SIGINT) == 1 || sigismember(&pending, SIGTERM) == 1;
  return requested_;
}

}  // namespace odomd::tools
