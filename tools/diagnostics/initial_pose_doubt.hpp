// An [initial] pose that came with the configuration of another drive.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "daemon/core/config.hpp"
#include "estimator/common/measurement.hpp"

namespace odomd::tools {

/// What to mend where the pose that the configuration starts from lies far from what the camera saw
/// in the first fifth of a second; nothing where it saw nothing then.
[[nodiscard]] std::optional<std::string> initial_pose_doubt(
    const daemon::Config& config, std::span<const estimator::CameraPose> cameras,
    std::int64_t first_tick_ns);

}  // namespace odomd::tools
