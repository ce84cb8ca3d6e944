#include "tools/diagnostics/initial_pose_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tools/math/se2.hpp"

namespace odomd::tools {
namespace {

using estimator::CameraPose;
using estimator::Pose2;

constexpr double soon_s = 0.2;
constexpr double sigmas = 5.0;
constexpr const diagnostics::Kind& elsewhere = diagnostics::kind("initial_pose_elsewhere");

/// The motion from the initial pose to the camera's pose, of the centre of gravity.
Pose2 apart(const Pose2& initial, const CameraPose& seen, const Pose2& lever_arm) {
  return relative(initial, compose({seen.x, seen.y, seen.yaw}, inverse(lever_arm)));
}

double turn(const Pose2& motion) {
  return std::fabs(std::remainder(motion.yaw, 2.0 * std::numbers::pi));
}

}  // namespace

std::optional<diagnostics::Diagnostic> check_initial_pose(const daemon::Config& config,
                                                          std::span<const CameraPose> cameras,
                                                          std::int64_t first_tick_ns) {
  if (!config.initial_pose) return std::nullopt;
  const auto& arm = config.camera.lever_arm;
  const Pose2 lever_arm{arm[0], arm[1], arm[2]};
  const auto gap_s = [first_tick_ns](const CameraPose& seen) {
    return std::fabs(static_cast<double>(seen.capture_ns - first_tick_ns) * 1e-9);
  };
  const auto is_soon = [&](const CameraPose& seen) { return gap_s(seen) <= soon_s; };
  const auto first = std::ranges::find_if(cameras, is_soon);
  if (first == cameras.end()) return std::nullopt;
  const auto last = std::ranges::find_if_not(first, cameras.end(), is_soon) - 1;

  // The speed up to the last of them; before the first one the car may have moved 1.5 times as
  // fast.
  const double between_s =
      std::max(static_cast<double>(last->capture_ns - first->capture_ns) * 1e-9, 1e-3);
  const double speed = std::hypot(last->x - first->x, last->y - first->y) / between_s;
  const double rate = turn({0.0, 0.0, last->yaw - first->yaw}) / between_s;
  for (const CameraPose& seen : {*first, *last}) {  // either may be an outlier
    const Pose2 gap = apart(*config.initial_pose, seen, lever_arm);
    const double driven_s = 1.5 * gap_s(seen);
    const double beyond_m = std::hypot(gap.x, gap.y) - speed * driven_s -
                            sigmas * std::hypot(seen.sigma_x, seen.sigma_y);
    const double beyond_rad = turn(gap) - rate * driven_s - sigmas * seen.sigma_yaw;
    if (elsewhere.limits.hold(beyond_m) && elsewhere.limits.hold(beyond_rad)) return std::nullopt;
  }
  const Pose2 gap = apart(*config.initial_pose, *first, lever_arm);
  return found(elsewhere, config.file.string(),
               fmt::format("the initial pose ({:.2f} m, {:.2f} m, {:.0f} deg) lies {:.2f} m and "
                           "{:.0f} deg from what the camera saw first: it is of another drive",
                           config.initial_pose->x, config.initial_pose->y,
                           config.initial_pose->yaw * 180.0 / std::numbers::pi,
                           std::hypot(gap.x, gap.y), turn(gap) * 180.0 / std::numbers::pi));
}

}  // namespace odomd::tools
