// Poses and velocities in the plane: composition, and motion at a given velocity.
#pragma once

#include <array>
#include <cmath>
#include <numbers>

#include "estimator/common/estimate.hpp"

namespace odomd::estimator {

/// Velocity of the centre of gravity in the body frame [m/s, m/s, rad/s].
struct BodyVelocity {
  double v_x = 0.0;
  double v_y = 0.0;
  double yaw_rate = 0.0;
};

/// The same angle in [-π, π].
[[nodiscard]] inline double wrap_angle(double angle) noexcept {
  return std::remainder(angle, 2.0 * std::numbers::pi);
}

/// a - b, for continuous yaws.
[[nodiscard]] inline Pose2 operator-(const Pose2& a, const Pose2& b) noexcept {
  return {a.x - b.x, a.y - b.y, a.yaw - b.yaw};
}

/// a - b, with the yaw difference wrapped to [-π, π].
[[nodiscard]] inline std::array<double, 3> difference(const Pose2& a, const Pose2& b) noexcept {
  return {a.x - b.x, a.y - b.y, wrap_angle(a.yaw - b.yaw)};
}

/// a ∘ b: transforms the pose b from the frame a to the frame in which a is given.
[[nodiscard]] inline Pose2 compose(const Pose2& a, const Pose2& b) noexcept {
  const double c = std::cos(a.yaw);
  const double s = std::sin(a.yaw);
  return {a.x + c * b.x - s * b.y, a.y + s * b.x + c * b.y, a.yaw + b.yaw};
}

/// The T with T ∘ local = world, i.e. world ∘ local⁻¹.
[[nodiscard]] inline Pose2 frame_of(const Pose2& world, const Pose2& local) noexcept {
  const double yaw = world.yaw - local.yaw;
  const double c = std::cos(yaw);
  const double s = std::sin(yaw);
  return {world.x - (c * local.x - s * local.y), world.y - (s * local.x + c * local.y), yaw};
}

/// The exact solution of eqs 8 (x_dot) and 9 for a constant velocity in the body frame: an arc.
/// `dt` may be negative.
[[nodiscard]] inline Pose2 moved(const Pose2& pose, const BodyVelocity& v, double dt) noexcept {
  // The chord of the arc points along the heading after half the turn.
  const double half = 0.5 * v.yaw_rate * dt;
  const double chord = half == 0.0 ? dt : dt * std::sin(half) / half;
  const double along = chord * std::cos(half);
  const double across = chord * std::sin(half);
  return compose(pose,
                 {v.v_x * along - v.v_y * across, v.v_x * across + v.v_y * along, v.yaw_rate * dt});
}

[[nodiscard]] inline bool is_finite(const Pose2& pose) noexcept {
  return std::isfinite(pose.x) && std::isfinite(pose.y) && std::isfinite(pose.yaw);
}

/// No car is faster than this [m/s, rad/s].
inline constexpr double fastest = 300.0;
inline constexpr double fastest_turn = 100.0;
[[nodiscard]] inline bool is_possible(const BodyVelocity& v) noexcept {
  return std::abs(v.v_x) <= fastest && std::abs(v.v_y) <= fastest &&
         std::abs(v.yaw_rate) <= fastest_turn;
}

[[nodiscard]] inline bool is_finite(const BodyVelocity& v) noexcept {
  return std::isfinite(v.v_x) && std::isfinite(v.v_y) && std::isfinite(v.yaw_rate);
}

}  // namespace odomd::estimator
