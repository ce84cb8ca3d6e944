#include "daemon/core/mounting.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace odomd::daemon {
namespace {

using estimator::Source;

can::Sample* sample_of(std::span<can::Sample> samples, Source source) noexcept {
  const auto found =
      std::ranges::find(samples, static_cast<std::uint16_t>(source), &can::Sample::channel);
  return found == samples.end() ? nullptr : &*found;
}

}  // namespace

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

void turn_accelerations(std::span<can::Sample> samples, double yaw) noexcept {
  can::Sample* const along = sample_of(samples, Source::accel_x);
  can::Sample* const across = sample_of(samples, Source::accel_y);
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  const double x = along != nullptr ? along->value : unknown;
  const double y = across != nullptr ? across->value : unknown;
  const double c = std::cos(yaw);
  const double s = std::sin(yaw);
  if (along != nullptr) along->value = x * c - y * s;
  if (across != nullptr) across->value = x * s + y * c;
}

}  // namespace odomd::daemon
