// What signals do to the daemon: none ends it by accident.
#pragma once

#include "base/file_descriptor.hpp"

namespace odomd::daemon {

/// TERM, INT and HUP come by the descriptor (a signalfd) and are blocked for all threads that are
/// started after. Every other signal that would end the process is ignored, but for those of a
/// fault of its own. A segment that is cut short under it (SIGBUS) ends it with one line and
/// status 1. Throws std::system_error.
[[nodiscard]] FileDescriptor take_signals();

}  // namespace odomd::daemon
