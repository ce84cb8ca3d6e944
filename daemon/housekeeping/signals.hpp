// Signal handling: no signal ends the daemon by accident.
#pragma once

#include "base/file_descriptor.hpp"

namespace odomd::daemon {

/// TERM, INT and HUP arrive on the descriptor (a signalfd) and are blocked for all threads that are
/// started later. All other signals that would end the process are ignored, except those of its own
/// faults. When the segment is truncated while it is mapped (SIGBUS), the process ends with one
/// line and status 1. Throws std::system_error.
[[nodiscard]] FileDescriptor take_signals();

}  // namespace odomd::daemon
