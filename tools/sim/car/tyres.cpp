// The tyres: the force of one tyre, and for each wheel of the plant its motion over the ground, its
// load and its force on the car.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "tools/sim/car/plant.hpp"

namespace odomd::sim {
namespace {

Vector2 wheel_position(const PlantParameters& p, std::size_t wheel) {
  const double side = wheel % 2 == 0 ? 0.5 : -0.5;  // left wheels have even numbers
  const double wider = (wheel < rear_left ? 0.5 : -0.5) * p.track_difference;
  return {wheel < rear_left ? p.front_axle : -p.rear_axle, side * (p.track_width + wider)};
}

// Ackermann: the axes of both front wheels meet at the centre of the turn,
//   tan δ_i = l tan δ / (l - y_i tan δ)
double wheel_steering(const PlantParameters& p, std::size_t wheel, double steering) {
  if (wheel >= rear_left) return 0.0;
  const double l = p.front_axle + p.rear_axle, t = std::tan(steering);
  return std::atan2(l * t, l - wheel_position(p, wheel).y * t);
}

// The share of the requested torque that a wheel gets. The drive fades near its top speed, and a
// brake holds a wheel that it has stopped.
enum class Pedal : std::uint8_t { drive, brake };
double torque_part(const PlantParameters& p, Pedal pedal, double v_x, double tread, double force) {
  if (pedal == Pedal::brake)
    return std::clamp(std::copysign(1.0, v_x) * tread / p.walking_speed(), -1.0, 1.0);
  const double spinning = std::copysign(1.0, force) * tread;
  return std::clamp(5.0 * (1.0 - spinning / p.top_speed), 0.0, 1.0);
}

}  // namespace

Vector2 tyre_force(const Tyre& tyre, double load, double friction, double slip_x, double slip_y) {
  const double limit = friction * load;
  if (limit <= 0.0) return {};
  const double growth = std::pow(load / tyre.nominal_load, tyre.load_exponent);
  // s_x = C_κ κ / (μ F_z),   s_y = C_α tan α / (μ F_z)
  const double s_x = tyre.slip_stiffness * growth * slip_x / limit;
  const double s_y = tyre.cornering_stiffness * growth * slip_y / limit;
  const double s = std::hypot(s_x, s_y);
  if (s < 1e-9) return {limit * s_x, limit * s_y};
  // F = μ F_z sin(c atan(s / c))
  const double force = limit * std::sin(tyre.shape * std::atan(s / tyre.shape));
  return {force * s_x / s, force * s_y / s};
}

// Motion of a tyre over the ground, in its own axes.
struct Plant::WheelMotion {
  double steering = 0.0;
  double v_x = 0.0;          // of the hub
  double slide_x = 0.0;      // of the contact: hub - tread, V_sx
  double slide_y = 0.0;      // V_sy
  double transport_x = 0.0;  // speed at which the contact renews itself, per direction
  double transport_y = 0.0;
  double slip_x = 0.0;  // κ and tan α, after relaxation
  double slip_y = 0.0;
};

// Single-contact-point tyre with relaxation (Pacejka, ch. 7): the deflections u, v obey
//   u̇ = -V_sx - V_t u / σ_κ,   κ = u / σ_κ;      v̇ = -V_sy - V_t v / σ_α,   tan α = v / σ_α
// At standstill the tyre is a spring along u and v; its damping fades out as the wheel rolls. V_t
// is the faster of hub and tread, along y at least |V_sy| / 2, which limits κ and tan α to 2.
Plant::WheelMotion Plant::wheel_motion(const State& s, std::size_t wheel) const {
  const PlantParameters& p = parameters_;
  WheelMotion motion;
  motion.steering = wheel_steering(p, wheel, s[steer]);
  const Vector2 place = wheel_position(p, wheel);
  const Vector2 hub =
      rotate({s[vel_x] - s[rate] * place.y, s[vel_y] + s[rate] * place.x}, -motion.steering);
  const double tread = p.wheel_radius[wheel] * s[at(wheel, spin)];
  motion.v_x = hub.x;
  motion.slide_x = hub.x - tread;
  motion.slide_y = hub.y;
  const double rolling = std::max(std::abs(hub.x), std::abs(tread));
  motion.transport_x = rolling;
  motion.transport_y = std::max(rolling, 0.5 * std::abs(hub.y));

  const double length_y = p.relaxation_length, length_x = 0.5 * p.relaxation_length;
  // The damping fades out above the speed from which relaxation dominates.
  const double fade_speed = 0.2 * p.relaxation_length / p.tyre_damping;
  const double damping =
      rolling < fade_speed
          ? 0.5 * p.tyre_damping * (1.0 + std::cos(std::numbers::pi * rolling / fade_speed))
          : 0.0;
  motion.slip_x = (s[at(wheel, bend_x)] - 0.2 * damping * motion.slide_x) / length_x;
  motion.slip_y = (s[at(wheel, bend_y)] - damping * motion.slide_y) / length_y;
  return motion;
}

// Static load, plus the load that a_x moves to the rear and a_y to the outer wheels. On a rigid car
//   ΔF_z = m a_x h / l per axle,   ΔF_z = m a_y h / w, divided between the axles by roll stiffness
std::array<double, wheel_count> Plant::loads(const State& s) const {
  const PlantParameters& p = parameters_;
  LoadShift shift;
  if (p.suspension.present()) {
    const Tracks tracks{.wheelbase = p.front_axle + p.rear_axle,
                        .front = p.track_width + 0.5 * p.track_difference,
                        .rear = p.track_width - 0.5 * p.track_difference};
    shift = load_shift(p.suspension, p.mass, attitude(s), tracks, s[shift_x], s[shift_y]);
  } else {
    const double across = p.mass * s[shift_y] * p.centre_height / p.track_width;
    shift = {.to_rear = p.mass * s[shift_x] * p.centre_height / (p.front_axle + p.rear_axle),
             .front_to_right = p.roll_front_share * across,
             .rear_to_right = (1.0 - p.roll_front_share) * across};
  }
  const double upright = up_on(road_).z;
  std::array<double, wheel_count> result{};
  for (std::size_t wheel = 0; wheel < wheel_count; ++wheel) {
    const bool front = wheel < rear_left;
    const double along = front ? -0.5 * shift.to_rear : 0.5 * shift.to_rear;
    const double across = front ? shift.front_to_right : shift.rear_to_right;
    result[wheel] = std::max(
        0.0, tyres_[wheel].nominal_load * upright + along + (wheel % 2 == 0 ? -across : across));
  }
  return result;
}

double Plant::friction_at(double x, double y) const {
  for (const FrictionPatch& patch : parameters_.patches)
    if (std::hypot(x - patch.x, y - patch.y) <= patch.radius) return patch.friction;
  return parameters_.friction;
}

// Tyre and drag forces and yaw moment on the body; writes derivatives of wheel states to `rates`.
Plant::GroundForces Plant::wheel_forces(const State& state, State& rates) const {
  const PlantParameters& p = parameters_;
  const State& s = state;
  const std::array<double, wheel_count> load = loads(s);
  const Pedal pedal = s[drive] * s[vel_x] < 0.0 && std::abs(s[vel_x]) > p.walking_speed()
                          ? Pedal::brake
                          : Pedal::drive;
  GroundForces force{.x = -p.drag * s[vel_x] * std::abs(s[vel_x])};
  for (std::size_t wheel = 0; wheel < wheel_count; ++wheel) {
    const bool front = wheel < rear_left;
    const double radius = p.wheel_radius[wheel];
    const WheelMotion motion = wheel_motion(s, wheel);
    const Vector2 place = wheel_position(p, wheel);
    const Vector2 ahead = rotate(place, s[heading]);
    const double friction = friction_at(s[pos_x] + ahead.x, s[pos_y] + ahead.y);
    const Vector2 tyre =
        tyre_force(tyres_[wheel], load[wheel], friction, motion.slip_x, motion.slip_y);

    const double rolling =
        p.rolling_resistance * load[wheel] * std::tanh(motion.v_x / p.walking_speed());
    const Vector2 on_body = rotate({tyre.x - rolling, tyre.y}, motion.steering);
    force.x += on_body.x;
    force.y += on_body.y;
    force.moment += place.x * on_body.y - place.y * on_body.x;

    // I ω̇ = T - r F_x; an open differential gives both wheels of an axle the same torque.
    const double front_share = pedal == Pedal::brake ? p.brake_front_share : p.drive_front_share;
    double torque = 0.5 * (front ? front_share : 1.0 - front_share) * s[drive] * radius *
                    torque_part(p, pedal, s[vel_x], radius * s[at(wheel, spin)], s[drive]);
    if (p.torque_limit > 0.0) {
      const double most = p.torque_limit * friction * load[wheel] * radius;
      torque = std::clamp(torque, -most, most);
    }
    rates[at(wheel, spin)] = (torque - radius * tyre.x) / p.spin_inertia(wheel);
    rates[at(wheel, turned)] = s[at(wheel, spin)];
    rates[at(wheel, bend_x)] =
        -motion.slide_x - motion.transport_x * s[at(wheel, bend_x)] / (0.5 * p.relaxation_length);
    rates[at(wheel, bend_y)] =
        -motion.slide_y - motion.transport_y * s[at(wheel, bend_y)] / p.relaxation_length;
  }
  return force;
}

}  // namespace odomd::sim
