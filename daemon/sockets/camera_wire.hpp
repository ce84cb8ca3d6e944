// One camera message, from the bytes of the wire to a pose on the daemon's clock. Pure.
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

/// Why a message was not understood.
enum class MalformedCause : std::uint8_t {
  none,
  size,      ///< not sizeof(odom_camera_message) bytes
  magic,     ///< not ODOM_CAMERA_MAGIC
  version,   ///< not ODOM_CAMERA_VERSION
  clock,     ///< not an odom_clock
  no_log,    ///< stamped by the clock of a log, of which no frame has come
  time,      ///< so far off that it cannot be converted
  reserved,  ///< the reserved word is not 0
  count
};
inline constexpr std::array<std::string_view, static_cast<std::size_t>(MalformedCause::count)>
    malformed_texts{"",
                    "it is not 80 bytes long",
                    "it does not begin with the magic number",
                    "it is of a version that this odomd does not know",
                    "it names a clock that does not exist",
                    "it is stamped by the clock of a log, of which no frame has come: no log is "
                    "played, or not yet",
                    "its time is out of all range",
                    "its reserved word is not 0"};

/// What is known of the clocks that a message may name.
struct MessageClocks {
  const WallClock& wall;               ///< has been read at least once
  std::optional<std::int64_t> log_ns;  ///< log clock - CLOCK_MONOTONIC, while a log is played
};

struct CameraMessage {
  MalformedCause cause = MalformedCause::none;
  estimator::CameraPose pose;  ///< of the reference point; meaningful where cause is none
};

/// `bytes` is the message as it was received; `size` how long it truly was (it may have been cut).
/// Values that are not finite pass: the filter has a verdict for them. Real-time safe.
[[nodiscard]] CameraMessage read_camera_message(std::span<const std::byte> bytes, std::size_t size,
                                                const MessageClocks& clocks,
                                                std::int64_t arrival_ns) noexcept;

}  // namespace odomd::daemon
