// Converts one camera message from bytes to a pose on the daemon's clock. Pure.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include <odom/odom.h>

#include "base/wall_clock.hpp"
#include "estimator/common/measurement.hpp"

namespace odomd::daemon {

/// Why a message is invalid.
enum class MalformedCause : std::uint8_t {
  none,
  size,      ///< not sizeof(odom_camera_message) bytes
  magic,     ///< not ODOM_CAMERA_MAGIC
  version,   ///< not ODOM_CAMERA_VERSION
  clock,     ///< not an odom_clock
  no_log,    ///< stamped with the log clock, but no frame of a log has arrived
  time,      ///< so far away that it cannot be converted
  reserved,  ///< the reserved word is not 0
  count
};
inline constexpr std::array<std::string_view, static_cast<std::size_t>(MalformedCause::count)>
    malformed_texts{"",
                    "it is not 80 bytes long",
                    "it does not begin with the magic number",
                    "this odomd does not know its version",
                    "it names an unknown clock",
                    "it is stamped with the log clock, but no log is being played yet",
                    "its time is out of range",
                    "its reserved word is not 0"};

/// The state of the clocks that a message may use.
struct MessageClocks {
  const WallClock& wall;               ///< has been read at least once
  std::optional<std::int64_t> log_ns;  ///< log clock - CLOCK_MONOTONIC, while a log is played
};

struct CameraMessage {
  MalformedCause cause = MalformedCause::none;
  estimator::CameraPose pose;  ///< of the reference point; valid when cause is none
};

/// `bytes` is the received message, `size` its original size (it may have been truncated).
/// Non-finite values are accepted: the filter has a verdict for them. Real-time safe.
[[nodiscard]] CameraMessage read_camera_message(std::span<const std::byte> bytes, std::size_t size,
                                                const MessageClocks& clocks,
                                                std::int64_t arrival_ns) noexcept;

}  // namespace odomd::daemon
