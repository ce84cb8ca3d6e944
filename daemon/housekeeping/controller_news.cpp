#include "daemon/housekeeping/controller_news.hpp"

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

/// A statistic's growth; where it went back the driver was loaded anew and counts from 0.
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

std::optional<News> ControllerNews::look(const std::string& interface,
                                         const std::optional<can::Controller>& controller,
                                         std::int64_t now_ns) {
  if (!controller) {  // gone, and with it what it counted
    told_statistics_.reset();
    return std::nullopt;
  }
  const bool taking_part = controller->health != ControllerHealth::stopped &&
                           controller->health != ControllerHealth::sleeping;
  if (!taking_part || (told_ns_ && now_ns - *told_ns_ < quiet_ns)) return std::nullopt;

  std::uint32_t bus_offs = 0;
  if (told_statistics_ && controller->statistics)
    bus_offs = growth(told_statistics_->bus_offs, controller->statistics->bus_offs);
  auto news = say(interface, *controller, bus_offs);
  told_statistics_ = controller->statistics;
  if (news) told_ns_ = now_ns;
  return news;
}

std::optional<News> ControllerNews::say(const std::string& interface,
                                        const can::Controller& controller, std::uint32_t bus_offs) {
  const ControllerHealth before = told_;
  const ControllerHealth now = controller.health;
  if (now == ControllerHealth::bus_off) {
    told_ = now;
    if (before == ControllerHealth::bus_off && bus_offs == 0) return std::nullopt;
    return News{Weight::warning,
                fmt::format("{}: bus-off: the controller has left the bus and hears nothing; {}",
                            interface, way_back(interface, controller))};
  }
  // The first bus-off of those that ended was spoken of if it was still going on then.
  const bool was_off = before == ControllerHealth::bus_off;
  if (was_off || bus_offs > 0) {
    told_ = now;
    if (bus_offs == 0)
      return News{Weight::info,
                  fmt::format("{}: the controller was restarted after bus-off and is {}", interface,
                              in_words(now))};
    return News{
        Weight::warning,
        fmt::format("{}: the controller went bus-off {}{} and was restarted, it is {}; check "
                    "bit rate, wiring and termination",
                    interface, bus_offs == 1 ? "once" : fmt::format("{} times", bus_offs),
                    was_off ? " more" : "", in_words(now))};
  }
  if (now == ControllerHealth::error_passive && before != now) {
    told_ = now;
    return News{Weight::warning,
                fmt::format("{}: error-passive: the controller meets too many errors{}; check bit "
                            "rate, wiring and termination, and that another node is on the bus",
                            interface, errors_of(controller))};
  }
  if (now == ControllerHealth::error_active && before == ControllerHealth::error_passive) {
    told_ = now;
    return News{Weight::info, fmt::format("{}: the controller is error-active again", interface)};
  }
  return std::nullopt;
}

}  // namespace odomd::daemon
