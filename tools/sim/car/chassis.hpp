// A body on springs rolls and pitches, moves load between the wheels through its springs, and tilts
// the sensors that are mounted on it. Also the tilt of the road.
//
// Axes of ISO 8855: x forward, y left, z up; roll φ is positive to the right, pitch θ positive nose
// down, both of the body relative to the road. The body turns about axes on the ground.
#pragma once

#include <cmath>

namespace odomd::sim {

inline constexpr double standard_gravity = 9.80665;  // m/s²

/// In the plane; SI units.
struct Vector2 {
  double x = 0.0, y = 0.0;
};

[[nodiscard]] inline Vector2 rotate(Vector2 v, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * v.x - s * v.y, s * v.x + c * v.y};
}

/// SI units. A rigid body has a sprung mass of 0.
struct Suspension {
  double sprung_mass = 0.0;
  double sprung_height = 0.0;         ///< h, of the sprung mass above the ground
  double unsprung_height = 0.0;       ///< of the unsprung masses above the ground
  double roll_inertia = 0.0;          ///< of the sprung mass, about its own centre
  double pitch_inertia = 0.0;         ///< of the sprung mass, about its own centre
  double roll_stiffness_front = 0.0;  ///< springs, anti-roll bar and tyres of an axle [N m/rad]
  double roll_stiffness_rear = 0.0;
  double roll_damping_front = 0.0;  ///< [N m s/rad]
  double roll_damping_rear = 0.0;
  double pitch_stiffness = 0.0;
  double pitch_damping = 0.0;

  [[nodiscard]] bool present() const { return sprung_mass > 0.0; }

  /// Roll / lateral acceleration in a steady turn, and pitch / deceleration in steady braking
  /// [rad/(m/s²)].
  [[nodiscard]] double roll_gradient() const;
  [[nodiscard]] double pitch_gradient() const;
};

/// The road under the car, in the car's heading, and its change as the car moves.
struct RoadTilt {
  double grade = 0.0;       ///< γ, uphill positive [rad]
  double bank = 0.0;        ///< ρ, the left side up positive [rad]
  double grade_rate = 0.0;  ///< [rad/s]
  double bank_rate = 0.0;
};

/// Attitude of the body relative to the road.
struct Attitude {
  double roll = 0.0, roll_rate = 0.0;
  double pitch = 0.0, pitch_rate = 0.0;
};

/// The accelerations of the body: of the point on the ground below the centre of gravity [m/s²],
/// and of the attitude [rad/s²].
struct BodyAcceleration {
  double x = 0.0, y = 0.0;
  double roll = 0.0, pitch = 0.0;
};

/// The accelerations of a car of `mass` under these forces from the ground and the air.
[[nodiscard]] BodyAcceleration body_acceleration(const Suspension& suspension, double mass,
                                                 const Attitude& attitude, const RoadTilt& road,
                                                 double force_x, double force_y);

/// The accelerations of a car whose wheels are at rest.
[[nodiscard]] BodyAcceleration body_acceleration_at_rest(const Suspension& suspension,
                                                         const Attitude& attitude,
                                                         const RoadTilt& road);

/// Load shifted to the rear axle, and on each axle to the right wheel [N].
struct LoadShift {
  double to_rear = 0.0;
  double front_to_right = 0.0;
  double rear_to_right = 0.0;
};

struct Tracks {
  double wheelbase = 0.0, front = 0.0, rear = 0.0;  ///< [m]
};

/// `specific_x`, `specific_y`: specific force of the unsprung masses [m/s²], including gravity on a
/// road that is not level.
[[nodiscard]] LoadShift load_shift(const Suspension& suspension, double mass,
                                   const Attitude& attitude, const Tracks& tracks,
                                   double specific_x, double specific_y);

/// The upward unit vector in the axes of the road.
struct Up {
  double x = 0.0, y = 0.0, z = 1.0;
};
[[nodiscard]] Up up_on(const RoadTilt& road);

}  // namespace odomd::sim
