#include "daemon/housekeeping/controllers.hpp"

#include <pthread.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include <fmt/format.h>

namespace odomd::daemon {
namespace {

constexpr std::chrono::milliseconds look_every{1000};
constexpr std::chrono::milliseconds look_at_most_every{100};  // even if there are many events

/// "it restarts after 100 ms", or how to restart it.
std::string restart_of(const std::string& interface, const can::Controller& controller) {
  const std::uint32_t restart_ms = controller.restart_ms.value_or(0);
  if (restart_ms > 0) return fmt::format("it restarts after {} ms", restart_ms);
  return fmt::format(
      "it does not restart by itself: ip link set {0} down; ip link set {0} type can restart-ms "
      "100 (where the driver can); ip link set {0} up",
      interface);
}

}  // namespace

ControllerWatch::ControllerWatch(std::vector<std::string> interfaces)
    : interfaces_(std::move(interfaces)), seen_(interfaces_.size()) {
  const bool any = std::ranges::any_of(interfaces_, [](const auto& name) { return !name.empty(); });
  if (any) thread_ = std::thread([this] { run(); });
}

ControllerWatch::~ControllerWatch() {
  {
    const std::scoped_lock lock(mutex_);
    stop_ = true;
  }
  wake_.notify_one();
  if (thread_.joinable()) thread_.join();
}

std::optional<can::Controller> ControllerWatch::latest(std::size_t bus) const {
  const std::scoped_lock lock(mutex_);
  return seen_[bus];
}

void ControllerWatch::look_again() {
  {
    const std::scoped_lock lock(mutex_);
    asked_ = true;
  }
  wake_.notify_one();
}

void ControllerWatch::run() {
  ::pthread_setname_np(::pthread_self(), "odomd-buses");
  std::unique_lock lock(mutex_);
  while (!stop_) {
    asked_ = false;
    for (std::size_t bus = 0; bus < interfaces_.size() && !stop_; ++bus) {
      if (interfaces_[bus].empty()) continue;
      lock.unlock();
      auto controller = can::read_controller(interfaces_[bus]);
      lock.lock();
      seen_[bus] = std::move(controller);
    }
    wake_.wait_for(lock, look_at_most_every, [this] { return stop_; });
    wake_.wait_for(lock, look_every - look_at_most_every, [this] { return stop_ || asked_; });
  }
}

std::optional<ControllerReport> report_change(can::ControllerHealth& reported,
                                              const std::string& interface,
                                              const can::Controller& controller) {
  using enum can::ControllerHealth;
  const can::ControllerHealth now = controller.health;
  if (now == reported || (now != error_active && now != error_passive && now != bus_off))
    return std::nullopt;
  const can::ControllerHealth before = std::exchange(reported, now);
  if (now == bus_off)
    return ControllerReport{
        Severity::warning,
        fmt::format("{}: bus-off: the controller has left the bus and receives nothing; {}",
                    interface, restart_of(interface, controller))};
  const std::string_view name = now == error_active ? "error-active" : "error-passive";
  if (before == bus_off)
    return ControllerReport{
        Severity::info,
        fmt::format("{}: the controller was restarted after bus-off and is {}", interface, name)};
  if (now == error_active)
    return ControllerReport{Severity::info,
                            fmt::format("{}: the controller is error-active again", interface)};
  const std::string errors = controller.errors
                                 ? fmt::format(" (error counters: transmit {}, receive {})",
                                               controller.errors->txerr, controller.errors->rxerr)
                                 : "";
  return ControllerReport{
      Severity::warning,
      fmt::format("{}: error-passive: the controller sees too many errors{}; check bit rate, "
                  "wiring and termination, and that another node is on the bus",
                  interface, errors)};
}

}  // namespace odomd::daemon
