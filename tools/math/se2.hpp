// Rigid motions in the plane: a pose is the transformation from its own frame to the map. Their
// composition is in estimator/common/pose.hpp. Also the degrees in a radian.
#pragma once

#include <cmath>
#include <numbers>

#include "estimator/common/pose.hpp"

namespace odomd::tools {

inline constexpr double degrees = 180.0 / std::numbers::pi;  ///< in a radian

[[nodiscard]] inline double distance(const estimator::Pose2& a, const estimator::Pose2& b) {
  return std::hypot(b.x - a.x, b.y - a.y);
}

/// a⁻¹: compose(inverse(a), a) is the identity.
[[nodiscard]] inline estimator::Pose2 inverse(const estimator::Pose2& a) {
  const double c = std::cos(a.yaw);
  const double s = std::sin(a.yaw);
  return {-c * a.x - s * a.y, s * a.x - c * a.y, -a.yaw};
}

/// The pose b in the frame of a: a⁻¹ ∘ b. Subtracts first, to keep the digits of poses far from the
/// origin.
[[nodiscard]] inline estimator::Pose2 relative(const estimator::Pose2& a,
                                               const estimator::Pose2& b) {
  const double c = std::cos(a.yaw);
  const double s = std::sin(a.yaw);
  const double dx = b.x - a.x;
  const double dy = b.y - a.y;
  return {c * dx + s * dy, -s * dx + c * dy, b.yaw - a.yaw};
}

}  // namespace odomd::tools
