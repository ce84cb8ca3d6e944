// What systemd is told: ready, how it goes, stopping, and that the beat still beats. Without a
// service manager every call does nothing.
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

  /// Feeds it when it is time, but only when the ticks have moved since the last time: a beat that
  /// hangs is to be restarted.
  void feed(std::uint64_t ticks, std::int64_t now_ns);

 private:
  std::int64_t feed_every_ns_ = 0;  // 0: there is none
  std::int64_t last_fed_ns_ = 0;
  std::uint64_t last_ticks_ = 0;
};

}  // namespace odomd::daemon
