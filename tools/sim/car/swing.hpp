// A car on two cords: a rigid body in space that hangs on two stiff springs, with air drag. It does
// not follow the equation from which the pendulum's period is computed: it sways, tilts, bounces,
// and does not hang exactly at its centre of gravity.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>

#include "tools/sim/car/plant.hpp"

namespace odomd::sim {

/// SI units; the cords are spaced along the car's y axis.
struct SwingParameters {
  double mass = 0.0;
  Eigen::Vector3d inertia = Eigen::Vector3d::Zero();  ///< principal, about x, y, z
  double gravity = 9.81;
  double spacing_above = 0.0;
  double spacing_below = 0.0;
  double cord = 0.0;          ///< length under the car's weight
  double stretch = 0.0;       ///< extension under the car's weight
  double offset_along = 0.0;  ///< of the centre of gravity from the midpoint, along the cords' line
  double offset_across = 0.0;         ///< the same across the line
  double height_of_attachment = 0.0;  ///< above the centre of gravity
  double viscous = 0.0;               ///< torque / yaw rate [N m s]
  double quadratic = 0.0;             ///< torque / yaw rate² [N m s²]
  double sway_drag = 0.0;             ///< force / speed [N s/m]
  double amplitude = 0.0;             ///< initial deflection [rad]
  double push = 0.0;                  ///< initial sideways speed [m/s]
};

class SwingRig {
 public:
  /// Starts at rest, deflected by the amplitude.
  explicit SwingRig(const SwingParameters& parameters);

  void step(double dt);  ///< swings; at most half a millisecond

  [[nodiscard]] const PlantOutput& output() const { return output_; }

 private:
  /// Position and velocity in the world, attitude (quaternion, w first) and angular velocity in
  /// body axes (spin); each begins at its index.
  using State = Eigen::Vector<double, 13>;
  enum : Eigen::Index { position = 0, velocity = 3, attitude = 6, spin = 10 };
  [[nodiscard]] State derivative(const State& state) const;
  void write_output();

  SwingParameters p_;
  std::array<Eigen::Vector3d, 2> above_;  // attachment points, in the world
  std::array<Eigen::Vector3d, 2> below_;  // attachment points, in the body
  double rest_length_ = 0.0;
  double stiffness_ = 0.0;
  State state_ = State::Zero();
  PlantOutput output_;
};

}  // namespace odomd::sim
