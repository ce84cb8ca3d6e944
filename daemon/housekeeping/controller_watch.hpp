// Reads the state of the CAN controllers of the buses, once a second and after errors, in a thread
// of its own: the kernel answers under a lock that a driver may hold for seconds, and neither the
// beat nor housekeeping (which notifies the watchdog) may wait for that.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "can_protocol/sources/controller.hpp"

namespace odomd::daemon {

class ControllerWatch {
 public:
  /// One name per bus; an empty name has no controller (a log).
  explicit ControllerWatch(std::vector<std::string> interfaces);
  ~ControllerWatch();
  ControllerWatch(const ControllerWatch&) = delete;
  ControllerWatch& operator=(const ControllerWatch&) = delete;

  /// The latest state; empty without a controller, and before the first read.
  [[nodiscard]] std::optional<can::Controller> latest(std::size_t bus) const;

  /// Reads the state at once instead of in a second, because something happened.
  void look_again();

 private:
  void run();

  const std::vector<std::string> interfaces_;
  mutable std::mutex mutex_;  // guards all below it
  std::condition_variable wake_;
  std::vector<std::optional<can::Controller>> seen_;
  bool asked_ = false;
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace odomd::daemon
