// Whether a restarted daemon goes on from the pose that its predecessor published last.
#pragma once

#include <cstdint>
#include <optional>

#include <odom/types.h>

namespace odomd::daemon {

/// A pose is gone on from while it is younger than this.
inline constexpr std::int64_t inheritance_ns = 2'000'000'000;

/// How old the pose is; nothing where it is too old, of the future, or none to go on from.
[[nodiscard]] constexpr std::optional<std::int64_t> age_to_go_on_from(
    const odom_pose& pose, std::int64_t now_ns) noexcept {
  if (pose.mode == ODOM_INITIALISING || pose.mode == ODOM_FAULT) return std::nullopt;
  // Compared before it is subtracted: what lies in a file may be any number.
  if (pose.time_ns > now_ns || pose.time_ns <= now_ns - inheritance_ns) return std::nullopt;
  return now_ns - pose.time_ns;
}

}  // namespace odomd::daemon
