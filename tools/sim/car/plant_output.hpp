// What sensors could measure on the car at one time.
#pragma once

#include <array>
#include <cstddef>

namespace odomd::sim {

enum Wheel : std::size_t { front_left, front_right, rear_left, rear_right, wheel_count };

/// The observable motion of the car's centre of gravity at one time. Plain numbers, so that two of
/// them can be interpolated.
struct PlantOutput {
  double x = 0.0, y = 0.0, yaw = 0.0;  ///< yaw is continuous
  double v_x = 0.0, v_y = 0.0, yaw_rate = 0.0;
  /// Acceleration along the road, that of gravity not included, and d(yaw_rate)/dt.
  double accel_x = 0.0, accel_y = 0.0, yaw_accel = 0.0;
  double steering = 0.0;  ///< where the front wheels are
  double commanded_steering = 0.0;
  std::array<double, wheel_count> wheel_angle{};  ///< turned since the start [rad]
  std::array<double, wheel_count> wheel_rate{};   ///< [rad/s]
  /// Of the body against the road, and of the road.
  double roll = 0.0, pitch = 0.0;
  double roll_rate = 0.0, pitch_rate = 0.0;
  double roll_accel = 0.0, pitch_accel = 0.0;
  double grade = 0.0, bank = 0.0;
  double grade_rate = 0.0, bank_rate = 0.0;

  [[nodiscard]] bool is_level() const {
    return roll == 0.0 && pitch == 0.0 && roll_rate == 0.0 && pitch_rate == 0.0 &&
           roll_accel == 0.0 && pitch_accel == 0.0 && grade == 0.0 && bank == 0.0;
  }
};

[[nodiscard]] PlantOutput interpolate(const PlantOutput& from, const PlantOutput& to, double part);

struct BodyForce {
  double x = 0.0, y = 0.0;
};

/// Specific force (as measured by an accelerometer) at a point of the body, in body axes; `z` is
/// above the ground.
[[nodiscard]] BodyForce specific_force_at(const PlantOutput& output, double x, double y,
                                          double z = 0.0);

/// The rate measured by a gyro about the body's own upward axis [rad/s].
[[nodiscard]] double body_yaw_rate(const PlantOutput& output);

}  // namespace odomd::sim
