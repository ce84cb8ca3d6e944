// What is worth a line in the log about a CAN controller, from one look at it to the next.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "can_protocol/sources/controller.hpp"

namespace odomd::daemon {

enum class Weight : std::uint8_t { info, warning };

struct News {
  Weight weight = Weight::info;
  std::string text;  ///< one line, with the mend
};

/// Speaks of error-passive, bus-off, and the way back; at most once a second, so that a controller
/// that goes bus-off and restarts ten times a second does not fill the log. Then one line sums up.
class ControllerNews {
 public:
  [[nodiscard]] std::optional<News> look(const std::string& interface,
                                         const std::optional<can::Controller>& controller,
                                         std::int64_t now_ns);

 private:
  std::optional<News> say(const std::string& interface, const can::Controller& controller,
                          std::uint32_t bus_offs);

  can::ControllerHealth told_ = can::ControllerHealth::error_active;
  std::optional<can::ControllerStatistics> told_statistics_;
  std::optional<std::int64_t> told_ns_;
};

}  // namespace odomd::daemon
