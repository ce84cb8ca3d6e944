// Detects an [initial] pose from the configuration of another drive.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "daemon/core/config.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "estimator/common/measurement.hpp"

namespace odomd::tools {

/// Whether the configured initial pose is far from the camera's poses in the first fifth of a
/// second; nothing if there are none.
[[nodiscard]] std::optional<diagnostics::Diagnostic> check_initial_pose(
    const daemon::Config& config, std::span<const estimator::CameraPose> cameras,
    std::int64_t first_tick_ns);

}  // namespace odomd::tools
