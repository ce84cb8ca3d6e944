// The CAN controller of an interface: its bit timing, its health and its statistics. Read from the
// kernel (rtnetlink, through libsocketcan); nothing here changes it.
#pragma once

#include <linux/can/netlink.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace odomd::can {

/// Fault confinement (ISO 11898-1, 12.1.4), as reported by the driver. A controller whose interface
/// is down is `stopped`.
enum class ControllerHealth : std::uint8_t {
  error_active,   ///< takes part in the bus; both error counters below 96
  error_warning,  ///< takes part; a counter at 96 or above
  error_passive,  ///< takes part, but may no longer flag errors; a counter at 128 or above
  bus_off,        ///< has left the bus; receives nothing until it is restarted
  stopped,
  sleeping
};

/// "error_active", ...
[[nodiscard]] std::string_view name_of(ControllerHealth health) noexcept;

/// Members that the driver does not report are empty.
struct Controller {
  ControllerHealth health = ControllerHealth::stopped;
  /// From bus-off to the restart; 0: no automatic restart.
  std::optional<std::uint32_t> restart_ms;
  /// The nominal bit timing (for CAN FD: of the arbitration phase); empty before a bit rate was
  /// set. sample_point is in permille of a bit, tq in ns, segments and sjw are in time quanta.
  /// Values that the driver does not report are 0.
  std::optional<can_bittiming> bit_timing;
  std::optional<std::uint32_t> clock_hz;
  std::vector<std::string_view> modes;  ///< those that are on: "loopback", "listen_only", "fd", ...
  std::optional<can_berr_counter> errors;  ///< the controller's transmit and receive counters
  /// Counts since the driver was loaded; they wrap. error_warning, error_passive and bus_off: how
  /// often the state was entered.
  std::optional<can_device_stats> statistics;
};

/// Queries the kernel. Empty when the interface has no controller (vcan) or does not exist. Makes
/// several queries, and the state may change between them. Takes a fraction of a millisecond, but
/// waits for the kernel's RTNL lock, which some drivers hold for seconds, so do not call it from
/// the beat. One thread at a time: while it runs, standard error of this process is muted, because
/// libsocketcan prints errors there for values that a driver does not report. Uses SIGURG to end a
/// query without an answer.
[[nodiscard]] std::optional<Controller> read_controller(const std::string& interface);

}  // namespace odomd::can
