#include "tools/sim/car/chassis.hpp"

#include <cmath>

namespace odomd::sim {
namespace {

// m_s h: couples the body's tilt to the car's motion.
double first_moment(const Suspension& s) {
  return s.sprung_mass * s.sprung_height;
}

// Inertia about the axis on the ground: J = I + m_s h²
double roll_inertia_on_ground(const Suspension& s) {
  return s.roll_inertia + first_moment(s) * s.sprung_height;
}
double pitch_inertia_on_ground(const Suspension& s) {
  return s.pitch_inertia + first_moment(s) * s.sprung_height;
}

// Moments of the springs and dampers on the body.
double roll_moment(const Suspension& s, const Attitude& a) {
  return (s.roll_stiffness_front + s.roll_stiffness_rear) * a.roll +
         (s.roll_damping_front + s.roll_damping_rear) * a.roll_rate;
}
double pitch_moment(const Suspension& s, const Attitude& a) {
  return s.pitch_stiffness * a.pitch + s.pitch_damping * a.pitch_rate;
}

}  // namespace

// K φ = m_s h (a_y + g φ)
double Suspension::roll_gradient() const {
  const double moment = sprung_mass * sprung_height;
  return moment / (roll_stiffness_front + roll_stiffness_rear - moment * standard_gravity);
}

// K θ = m_s h (-a_x + g θ)
double Suspension::pitch_gradient() const {
  const double moment = sprung_mass * sprung_height;
  return moment / (pitch_stiffness - moment * standard_gravity);
}

Up up_on(const RoadTilt& road) {
  return {std::sin(road.grade), std::cos(road.grade) * std::sin(road.bank),
          std::cos(road.grade) * std::cos(road.bank)};
}

// With the upward unit vector n in the axes of the road, and a_y + g n_y the specific force:
//   m a_y - m_s h φ̈ = F_y - m g n_y
//   J_φ φ̈ = m_s h (a_y + g n_y + g n_z sin φ) - K φ - C φ̇
//   m a_x + m_s h θ̈ = F_x - m g n_x
//   J_θ θ̈ = m_s h (-a_x - g n_x + g n_z sin θ) - K θ - C θ̇
// solved for the accelerations. (Tilting moves the sprung mass by -h φ to the left, h θ forward.)
BodyAcceleration body_acceleration(const Suspension& s, double mass, const Attitude& attitude,
                                   const RoadTilt& road, double force_x, double force_y) {
  const Up up = up_on(road);
  const double moment = first_moment(s);
  const double roll_inertia = roll_inertia_on_ground(s);
  const double pitch_inertia = pitch_inertia_on_ground(s);
  const double rolling =
      moment * standard_gravity * up.z * std::sin(attitude.roll) - roll_moment(s, attitude);
  const double pitching =
      moment * standard_gravity * up.z * std::sin(attitude.pitch) - pitch_moment(s, attitude);
  // Specific forces f = a + g n
  const double specific_y =
      (force_y + moment * rolling / roll_inertia) / (mass - moment * moment / roll_inertia);
  const double specific_x =
      (force_x - moment * pitching / pitch_inertia) / (mass - moment * moment / pitch_inertia);
  return {.x = specific_x - standard_gravity * up.x,
          .y = specific_y - standard_gravity * up.y,
          .roll = (moment * specific_y + rolling) / roll_inertia,
          .pitch = (-moment * specific_x + pitching) / pitch_inertia};
}

BodyAcceleration body_acceleration_at_rest(const Suspension& s, const Attitude& attitude,
                                           const RoadTilt& road) {
  const Up up = up_on(road);
  const double weight = first_moment(s) * standard_gravity;
  return {
      .roll = (weight * (up.y + up.z * std::sin(attitude.roll)) - roll_moment(s, attitude)) /
              roll_inertia_on_ground(s),
      .pitch = (weight * (-up.x + up.z * std::sin(attitude.pitch)) - pitch_moment(s, attitude)) /
               pitch_inertia_on_ground(s)};
}

// Springs and dampers load the wheels with the moment that holds the body; the unsprung masses,
// half of them on each axle, add the moment of their own specific force.
LoadShift load_shift(const Suspension& s, double mass, const Attitude& a, const Tracks& tracks,
                     double specific_x, double specific_y) {
  const double unsprung = (mass - s.sprung_mass) * s.unsprung_height;
  return {.to_rear = (unsprung * specific_x - pitch_moment(s, a)) / tracks.wheelbase,
          .front_to_right = (s.roll_stiffness_front * a.roll + s.roll_damping_front * a.roll_rate +
                             0.5 * unsprung * specific_y) /
                            tracks.front,
          .rear_to_right = (s.roll_stiffness_rear * a.roll + s.roll_damping_rear * a.roll_rate +
                            0.5 * unsprung * specific_y) /
                           tracks.rear};
}

}  // namespace odomd::sim
