// Detects an [initial] pose from the configuration of another drive.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "daemon/core/config.hpp"
#include "estimator/common/measurement.hpp"

namespace odomd::tools {

/// A warning if the configured initial pose is far from the camera's poses in the first fifth of a
/// second; nothing if there are none.
[[nodiscard]] std::optional<std::string> initial_pose_warning(
    const daemon::Config& config, std::span<const estimator::CameraPose> cameras,
    std::int64_t first_tick_ns);

}  // namespace odomd::tools
