// The daemon's process: signals, none of which ends it by accident, and notifications to systemd,
// which do nothing without a service manager.
#pragma once

#include <cstdint>

#include "base/file_descriptor.hpp"

namespace odomd::daemon {

/// TERM, INT and HUP arrive on the descriptor (a signalfd) and are blocked for all threads that are
/// started later. All other signals that would end the process are ignored, except those of its own
/// faults. When the segment is truncated while it is mapped (SIGBUS), the process ends with one
/// line and status 1. Throws std::system_error.
[[nodiscard]] FileDescriptor take_signals();

/// The service manager's watchdog (WatchdogSec=).
class Watchdog {
 public:
  Watchdog();

  /// Notifies the watchdog when due, but only if the tick count has increased since the last time,
  /// so that a daemon whose beat hangs is restarted.
  void notify(std::uint64_t ticks, std::int64_t now_ns);

 private:
  std::int64_t notify_every_ns_ = 0;  // 0: no watchdog
  std::int64_t last_notified_ns_ = 0;
  std::uint64_t last_ticks_ = 0;
};

}  // namespace odomd::daemon
