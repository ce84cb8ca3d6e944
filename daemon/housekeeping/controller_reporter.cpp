#include "daemon/housekeeping/controller_reporter.hpp"

#include <fmt/format.h>

namespace odomd::daemon {
namespace {

using can::ControllerHealth;

constexpr std::int64_t quiet_ns = 1'000'000'000;

std::string_view in_words(ControllerHealth health) {
  switch (health) {
    case ControllerHealth::error_warning:
      return "close to error-passive";
    case ControllerHealth::error_passive:
      return "error-passive";
    case ControllerHealth::error_active:
    case ControllerHealth::bus_off:
    case ControllerHealth::stopped:
    case ControllerHealth::sleeping:
      break;
  }
  return "error-active";
}

/// The growth of a counter; when it went back, the driver was reloaded and counts from 0.
std::uint32_t growth(std::uint32_t before, std::uint32_t now) {
  return now >= before ? now - before : now;
}

std::string errors_of(const can::Controller& controller) {
  if (!controller.errors) return "";
  return fmt::format(" (error counters: transmit {}, receive {})", controller.errors->transmit,
                     controller.errors->receive);
}

std::string way_back(const std::string& interface, const can::Controller& controller) {
  const std::uint32_t restart_ms = controller.restart_ms.value_or(0);
  if (restart_ms > 0) return fmt::format("it restarts after {} ms", restart_ms);
  return fmt::format(
      "it does not restart by itself: ip link set {0} down; ip link set {0} type can restart-ms "
      "100 (where the driver can); ip link set {0} up",
      interface);
}

}  // namespace

std::optional<ControllerReport> ControllerReporter::look(
    const std::string& interface, const std::optional<can::Controller>& controller,
    std::int64_t now_ns) {
  if (!controller) {  // gone, and its counters with it
    reported_statistics_.reset();
    return std::nullopt;
  }
  const bool taking_part = controller->health != ControllerHealth::stopped &&
                           controller->health != ControllerHealth::sleeping;
  if (!taking_part || (reported_ns_ && now_ns - *reported_ns_ < quiet_ns)) return std::nullopt;

  std::uint32_t bus_offs = 0;
  if (reported_statistics_ && controller->statistics)
    bus_offs = growth(reported_statistics_->bus_offs, controller->statistics->bus_offs);
  auto report = compose(interface, *controller, bus_offs);
  reported_statistics_ = controller->statistics;
  if (report) reported_ns_ = now_ns;
  return report;
}

std::optional<ControllerReport> ControllerReporter::compose(const std::string& interface,
                                                            const can::Controller& controller,
                                                            std::uint32_t bus_offs) {
  const ControllerHealth before = reported_;
  const ControllerHealth now = controller.health;
  if (now == ControllerHealth::bus_off) {
    reported_ = now;
    if (before == ControllerHealth::bus_off && bus_offs == 0) return std::nullopt;
    return ControllerReport{
        Severity::warning,
        fmt::format("{}: bus-off: the controller has left the bus and receives nothing; {}",
                    interface, way_back(interface, controller))};
  }
  // A bus-off that was reported while it was active is not among those counted here.
  const bool was_off = before == ControllerHealth::bus_off;
  if (was_off || bus_offs > 0) {
    reported_ = now;
    if (bus_offs == 0)
      return ControllerReport{
          Severity::info, fmt::format("{}: the controller was restarted after bus-off and is {}",
                                      interface, in_words(now))};
    return ControllerReport{
        Severity::warning,
        fmt::format("{}: the controller went bus-off {}{} and was restarted; it is now {}; check "
                    "bit rate, wiring and termination",
                    interface, bus_offs == 1 ? "once" : fmt::format("{} times", bus_offs),
                    was_off ? " more" : "", in_words(now))};
  }
  if (now == ControllerHealth::error_passive && before != now) {
    reported_ = now;
    return ControllerReport{
        Severity::warning,
        fmt::format("{}: error-passive: the controller sees too many errors{}; check bit "
                    "rate, wiring and termination, and that another node is on the bus",
                    interface, errors_of(controller))};
  }
  if (now == ControllerHealth::error_active && before == ControllerHealth::error_passive) {
    reported_ = now;
    return ControllerReport{Severity::info,
                            fmt::format("{}: the controller is error-active again", interface)};
  }
  return std::nullopt;
}

}  // namespace odomd::daemon
