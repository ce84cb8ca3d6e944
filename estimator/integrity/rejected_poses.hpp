// Camera poses that the gate of a baseline has rejected: when so many in a row agree with each
// other, but not with the odometry (wheels that spin or lock), the camera is right after all.
// docs/model.md, "The odometry frame, the map, and the camera".
#pragma once

#include <cstdint>

#include "estimator/common/pose.hpp"
#include "estimator/common/symmetric3.hpp"

namespace odomd::estimator {

inline constexpr int agreeing_rejections = 10;

/// What an odometry that is wrong may err by on the way from one pose to another within `dt` [s],
/// its error the same throughout: half of the way, and 0.5 m/s and 1 rad/s.
[[nodiscard]] Symmetric3 suspect_motion(const Pose2& from, const Pose2& to, double dt) noexcept;

struct RejectedPose {
  std::int64_t capture_ns = 0;
  Pose2 map;   ///< as the camera sees it
  Pose2 odom;  ///< at the capture
  Symmetric3 covariance{};
};

/// The last of the rejected poses, and how many in a row agree with it.
struct RejectedRun {
  int agreeing = 0;
  RejectedPose last;
};

/// Takes the next one in: true once enough of them agree. They do where the motion from one to the
/// next is the odometry's, give or take suspect_motion(), within the camera's gate; a pause of more
/// than half a second begins a new run.
[[nodiscard]] bool agree(RejectedRun& run, const RejectedPose& next, double gate) noexcept;

}  // namespace odomd::estimator
