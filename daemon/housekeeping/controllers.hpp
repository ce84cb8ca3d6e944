// The CAN controllers of the buses: reads their state, and composes log lines about its changes.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "can_protocol/sources/controller.hpp"

namespace odomd::daemon {

/// Reads the state once a second and after errors, in a thread of its own: the kernel answers under
/// a lock that a driver may hold for seconds, and neither the beat nor housekeeping (which notifies
/// the watchdog) may wait for that.
class ControllerWatch {
 public:
  /// One name per bus; an empty name has no controller (a log).
  explicit ControllerWatch(std::vector<std::string> interfaces);
  ~ControllerWatch();
  ControllerWatch(const ControllerWatch&) = delete;
  ControllerWatch& operator=(const ControllerWatch&) = delete;

  /// The latest state; empty without a controller, and before the first read.
  [[nodiscard]] std::optional<can::Controller> latest(std::size_t bus) const;

  /// After an event: makes the thread read the state now instead of up to a second later.
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

enum class Severity : std::uint8_t { info, warning };

struct ControllerReport {
  Severity severity = Severity::info;
  std::string text;  ///< one line, with the fix
};

/// The report of a controller that became error-passive, went bus-off, or recovered since
/// `reported`, which is then updated; empty if there is none. The state of a controller that is
/// stopped, asleep or close to error-passive is ignored.
[[nodiscard]] std::optional<ControllerReport> report_change(can::ControllerHealth& reported,
                                                            const std::string& interface,
                                                            const can::Controller& controller);

}  // namespace odomd::daemon
