// Notifies systemd: ready, status, stopping, and that the beat is alive. Without a service manager
// every call does nothing.
#pragma once

#include <cstdint>
#include <string>

namespace odomd::daemon {

void notify_ready();
void notify_stopping();
void notify_status(const std::string& text);

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
