#include "daemon/sockets/camera_wire.hpp"

#include <bit>
#include <cstring>

namespace odomd::daemon {
namespace {

static_assert(sizeof(odom_camera_message) == 80);
static_assert(std::endian::native == std::endian::little, "the wire is little-endian");

/// Beyond this (73 years) differences of times could overflow.
constexpr std::int64_t latest_ns = std::int64_t{1} << 61;

/// The capture time on CLOCK_MONOTONIC, or the reason why there is none. A picture may be older
/// than a step of the wall clock: its stamp is converted with the offset of that time. A stamp that
/// no offset makes recent is converted with the current offset, and the filter then gives its
/// verdict.
MalformedCause convert(const odom_camera_message& message, const MessageClocks& clocks,
                       std::int64_t arrival_ns, std::int64_t& capture_ns) noexcept {
  std::int64_t offset_ns = 0;
  switch (message.clock) {
    case ODOM_CLOCK_MONOTONIC:
      break;
    case ODOM_CLOCK_REALTIME:
      offset_ns = clocks.wall.offset_ns();
      break;
    case ODOM_CLOCK_LOG:
      if (!clocks.log_ns) return MalformedCause::no_log;
      offset_ns = *clocks.log_ns;
      break;
    default:
      return MalformedCause::clock;
  }
  if (__builtin_sub_overflow(message.capture_ns, offset_ns, &capture_ns) ||
      capture_ns > latest_ns || capture_ns < -latest_ns)
    return MalformedCause::time;
  if (message.clock == ODOM_CLOCK_REALTIME)
    capture_ns = clocks.wall.to_monotonic(message.capture_ns, arrival_ns).value_or(capture_ns);
  return MalformedCause::none;
}

}  // namespace

CameraMessage read_camera_message(std::span<const std::byte> bytes, std::size_t size,
                                  const MessageClocks& clocks, std::int64_t arrival_ns) noexcept {
  odom_camera_message message;
  if (size != sizeof message || bytes.size() < sizeof message) return {MalformedCause::size, {}};
  std::memcpy(&message, bytes.data(), sizeof message);
  if (message.magic != ODOM_CAMERA_MAGIC) return {MalformedCause::magic, {}};
  if (message.version != ODOM_CAMERA_VERSION) return {MalformedCause::version, {}};
  if (message.reserved != 0) return {MalformedCause::reserved, {}};

  std::int64_t capture_ns = 0;
  if (const auto cause = convert(message, clocks, arrival_ns, capture_ns);
      cause != MalformedCause::none)
    return {cause, {}};
  return {MalformedCause::none,
          {.capture_ns = capture_ns,
           .arrival_ns = arrival_ns,
           .x = message.x,
           .y = message.y,
           .yaw = message.yaw,
           .sigma_x = message.sigma_x,
           .sigma_y = message.sigma_y,
           .sigma_yaw = message.sigma_yaw}};
}

}  // namespace odomd::daemon
