#include "daemon/housekeeping/service_manager.hpp"

#include <systemd/sd-daemon.h>

namespace odomd::daemon {

void notify_ready() {
  ::sd_notify(0, "READY=1");
}

void notify_stopping() {
  ::sd_notify(0, "STOPPING=1");
}

void notify_status(const std::string& text) {
  ::sd_notify(0, ("STATUS=" + text).c_str());
}

Watchdog::Watchdog() {
  std::uint64_t limit_us = 0;
  // A third of the limit: one notification may be late.
  if (::sd_watchdog_enabled(0, &limit_us) > 0)
    notify_every_ns_ = static_cast<std::int64_t>(limit_us) * 1000 / 3;
}

void Watchdog::notify(std::uint64_t ticks, std::int64_t now_ns) {
  if (notify_every_ns_ == 0 || now_ns - last_notified_ns_ < notify_every_ns_ ||
      ticks == last_ticks_)
    return;
  last_notified_ns_ = now_ns;
  last_ticks_ = ticks;
  ::sd_notify(0, "WATCHDOG=1");
}

}  // namespace odomd::daemon
