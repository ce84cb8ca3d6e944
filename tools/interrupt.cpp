#include "tools/interrupt.hpp"

#include <ctime>

namespace odomd::tools {

Interrupt::Interrupt() {
  sigemptyset(&signals_);
  sigaddset(&signals_, SIGINT);
  sigaddset(&signals_, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals_, &before_);
}

Interrupt::~Interrupt() {
  if (!requested_) pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

bool Interrupt::requested() {
  constexpr timespec at_once{};
  if (!requested_) requested_ = sigtimedwait(&signals_, nullptr, &at_once) > 0;
  return requested_;
}

}  // namespace odomd::tools
