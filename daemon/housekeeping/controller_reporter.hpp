// Composes log lines about changes of a CAN controller between two checks.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "can_protocol/sources/controller.hpp"

namespace odomd::daemon {

enum class Severity : std::uint8_t { info, warning };

struct ControllerReport {
  Severity severity = Severity::info;
  std::string text;  ///< one line, with the fix
};

/// Reports error-passive, bus-off and the recovery, at most once a second, so that a controller
/// that goes bus-off and restarts ten times a second does not fill the log. One line sums them up.
class ControllerReporter {
 public:
  [[nodiscard]] std::optional<ControllerReport> look(
      const std::string& interface, const std::optional<can::Controller>& controller,
      std::int64_t now_ns);

 private:
  std::optional<ControllerReport> compose(const std::string& interface,
                                          const can::Controller& controller,
                                          std::uint32_t bus_offs);

  can::ControllerHealth reported_ = can::ControllerHealth::error_active;
  std::optional<can::ControllerStatistics> reported_statistics_;
  std::optional<std::int64_t> reported_ns_;
};

}  // namespace odomd::daemon
