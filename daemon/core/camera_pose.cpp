#include "daemon/core/camera_pose.hpp"

#include <cmath>

namespace odomd::daemon {

estimator::CameraPose to_centre_of_gravity(const estimator::CameraPose& reference,
                                           const std::array<double, 3>& lever_arm) noexcept {
  const auto& [arm_x, arm_y, arm_yaw] = lever_arm;
  estimator::CameraPose pose = reference;
  pose.yaw = reference.yaw - arm_yaw;

  // p_cog = p_ref − R(ψ) l
  const double c = std::cos(pose.yaw);
  const double s = std::sin(pose.yaw);
  const double dx = c * arm_x - s * arm_y;
  const double dy = s * arm_x + c * arm_y;
  pose.x = reference.x - dx;
  pose.y = reference.y - dy;

  // ∂p_cog/∂ψ = (dy, −dx): the uncertainty of the yaw rotates the lever arm.
  pose.sigma_x = std::hypot(reference.sigma_x, dy * reference.sigma_yaw);
  pose.sigma_y = std::hypot(reference.sigma_y, dx * reference.sigma_yaw);
  return pose;
}

}  // namespace odomd::daemon
