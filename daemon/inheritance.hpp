// Decides whether a restarted daemon resumes from the last pose of its predecessor.
#pragma once

#include <cstdint>
#include <optional>

#include <odom/types.h>

namespace odomd::daemon {

/// Resumes from a pose that is younger than this.
inline constexpr std::int64_t inheritance_ns = 2'000'000'000;

/// The age of the pose; empty when it is too old, in the future, or not usable.
[[nodiscard]] constexpr std::optional<std::int64_t> age_to_go_on_from(
    const odom_pose& pose, std::int64_t now_ns) noexcept {
  if (pose.mode == ODOM_INITIALISING || pose.mode == ODOM_FAULT) return std::nullopt;
  // Compared before the subtraction, because a file may contain any number.
  if (pose.time_ns > now_ns || pose.time_ns <= now_ns - inheritance_ns) return std::nullopt;
  return now_ns - pose.time_ns;
}

}  // namespace odomd::daemon
