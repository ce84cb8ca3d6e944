#include "tools/sim/car/plant.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "tools/sim/car/chassis.hpp"

namespace odomd::sim {

PlantOutput interpolate(const PlantOutput& from, const PlantOutput& to, double part) {
  using Numbers = std::array<double, sizeof(PlantOutput) / sizeof(double)>;
  auto a = std::bit_cast<Numbers>(from);
  const auto b = std::bit_cast<Numbers>(to);
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += part * (b[i] - a[i]);
  return std::bit_cast<PlantOutput>(a);
}

Vector2 specific_force_at(const PlantOutput& o, double x, double y, double z) {
  // a(p) = a + ψ̈ × p - ψ̇² p: Euler and centripetal terms of the lever arm
  if (o.is_level())
    return {o.accel_x - o.yaw_accel * y - o.yaw_rate * o.yaw_rate * x,
            o.accel_y + o.yaw_accel * x - o.yaw_rate * o.yaw_rate * y};

  // f = a + g n on the road, rotated to the body's axes, R = R_y(θ) R_x(φ)
  const Up up = up_on({.grade = o.grade, .bank = o.bank});
  const double f_x = o.accel_x + standard_gravity * up.x;
  const double f_y = o.accel_y + standard_gravity * up.y;
  const double f_z = standard_gravity * up.z;
  const double along = std::cos(o.pitch) * f_x - std::sin(o.pitch) * f_z;
  const double upward = std::sin(o.pitch) * f_x + std::cos(o.pitch) * f_z;
  const double across = std::cos(o.roll) * f_y + std::sin(o.roll) * upward;

  // f(p) = f + ω̇ × p + ω × (ω × p) = f + ω̇ × p + ω (ω · p) - ω² p
  const double p = o.roll_rate + o.bank_rate;
  const double q = o.pitch_rate - o.grade_rate;
  const double r = body_yaw_rate(o);
  const double on_axis = p * x + q * y + r * z;
  const double squared = p * p + q * q + r * r;
  return {along + o.pitch_accel * z - o.yaw_accel * y + p * on_axis - squared * x,
          across + o.yaw_accel * x - o.roll_accel * z + q * on_axis - squared * y};
}

// ω_z = ψ̇ cos θ cos φ - θ̇ sin φ, with the angles of the body relative to the horizon
double body_yaw_rate(const PlantOutput& o) {
  if (o.is_level()) return o.yaw_rate;
  const double over_roll = o.roll + o.bank, over_pitch = o.pitch - o.grade;
  return o.yaw_rate * std::cos(over_pitch) * std::cos(over_roll) -
         (o.pitch_rate - o.grade_rate) * std::sin(over_roll);
}

Plant::Plant(PlantParameters parameters, double x, double y, double yaw)
    : parameters_(std::move(parameters)) {
  const PlantParameters& p = parameters_;
  // F_z0 of the front axle = m g l_h / l
  const double wheelbase = p.front_axle + p.rear_axle;
  for (std::size_t wheel = 0; wheel < wheel_count; ++wheel) {
    const bool front = wheel < rear_left;
    const double stiffness =
        0.5 * (front ? p.cornering_stiffness_front : p.cornering_stiffness_rear);
    const double arm = front ? p.rear_axle : p.front_axle;
    tyres_[wheel] = {.cornering_stiffness = stiffness,
                     .slip_stiffness = p.slip_stiffness_ratio * stiffness,
                     .nominal_load = 0.5 * p.mass * standard_gravity * arm / wheelbase,
                     .shape = p.tyre_shape,
                     .load_exponent = p.tyre_load_exponent};
  }
  state_[pos_x] = x;
  state_[pos_y] = y;
  state_[heading] = yaw;
  write_output({});
}

double Plant::breakaway_force() const {
  return parameters_.rolling_resistance * parameters_.mass * standard_gravity;
}

Plant::Derivative Plant::derivative(const State& s, const PlantInput& input) const {
  const PlantParameters& p = parameters_;
  const bool sprung = p.suspension.present();
  Derivative result;
  State& d = result.rate;

  // Actuators: first order, the steering with a rate limit.
  const double wanted = std::clamp(input.steering, -p.steering_limit, p.steering_limit);
  d[steer] = std::clamp((wanted - s[steer]) / p.steering_lag, -p.steering_rate_limit,
                        p.steering_rate_limit);
  d[drive] = (input.force - s[drive]) / p.drive_lag;

  BodyAcceleration body;
  if (motion_ == Movement::rolling) {
    const GroundForces force = wheel_forces(s, d);
    body = sprung ? body_acceleration(p.suspension, p.mass, attitude(s), road_, force.x, force.y)
                  : BodyAcceleration{.x = force.x / p.mass, .y = force.y / p.mass};
    // v̇_x = a_x + v_y ψ̇,  v̇_y = a_y - v_x ψ̇
    d[vel_x] = body.x + s[vel_y] * s[rate];
    d[vel_y] = body.y - s[vel_x] * s[rate];
    d[rate] = force.moment / p.yaw_inertia;
    // Projected onto the map, a distance uphill or across a bank is shorter.
    const Vector2 over_ground =
        rotate({std::cos(road_.grade) * s[vel_x], std::cos(road_.bank) * s[vel_y]}, s[heading]);
    d[pos_x] = over_ground.x;
    d[pos_y] = over_ground.y;
    d[heading] = s[rate];
  } else if (sprung) {
    body = body_acceleration_at_rest(p.suspension, attitude(s), road_);
  }
  result.accel_x = body.x;
  result.accel_y = body.y;
  d[roll] = s[roll_rate];
  d[roll_rate] = body.roll;
  d[pitch] = s[pitch_rate];
  d[pitch_rate] = body.pitch;
  const Up up = up_on(road_);
  d[shift_x] = (result.accel_x + standard_gravity * up.x - s[shift_x]) / p.load_lag;
  d[shift_y] = (result.accel_y + standard_gravity * up.y - s[shift_y]) / p.load_lag;
  return result;
}

// Classic fourth-order Runge-Kutta.
void Plant::step(const PlantInput& input, double dt) {
  PlantInput acting = input;
  acting.steering = delayed(input.steering, dt);
  if (parameters_.suspension.present()) road_ = input.road;
  const auto moved = [this](const Derivative& k, double h) {
    State result = state_;
    for (std::size_t i = 0; i < result.size(); ++i) result[i] += h * k.rate[i];
    return result;
  };
  const Derivative k1 = derivative(state_, acting);
  const Derivative k2 = derivative(moved(k1, 0.5 * dt), acting);
  const Derivative k3 = derivative(moved(k2, 0.5 * dt), acting);
  const Derivative k4 = derivative(moved(k3, dt), acting);
  for (std::size_t i = 0; i < state_.size(); ++i)
    state_[i] += dt / 6.0 * (k1.rate[i] + 2.0 * k2.rate[i] + 2.0 * k3.rate[i] + k4.rate[i]);
  come_to_rest_or_go();
  write_output(acting);
  output_.commanded_steering = input.steering;
}

// The command from `steering_delay` ago; 0 before the first.
double Plant::delayed(double steering, double dt) {
  const auto steps = static_cast<std::size_t>(std::lround(parameters_.steering_delay / dt));
  if (steps == 0) return steering;
  commands_.push_back(steering);
  if (commands_.size() <= steps) return 0.0;
  const double then = commands_.front();
  commands_.pop_front();
  return then;
}

// Static friction: the car comes to rest exactly once it is slower than rest_speed everywhere and
// not driven; it moves again when the drive overcomes the rolling resistance.
void Plant::come_to_rest_or_go() {
  const PlantParameters& p = parameters_;
  const bool driven = std::abs(state_[drive]) > breakaway_force();
  if (driven) {
    motion_ = Movement::rolling;
    return;
  }
  if (motion_ == Movement::resting) return;
  double fastest = std::max({std::abs(state_[vel_x]), std::abs(state_[vel_y]),
                             std::abs(state_[rate]) * (p.front_axle + p.rear_axle)});
  for (std::size_t wheel = 0; wheel < wheel_count; ++wheel)
    fastest = std::max(fastest, std::abs(p.wheel_radius[wheel] * state_[at(wheel, spin)]));
  if (fastest > p.rest_speed) return;
  motion_ = Movement::resting;
  state_[vel_x] = state_[vel_y] = state_[rate] = 0.0;
  for (std::size_t wheel = 0; wheel < wheel_count; ++wheel)
    state_[at(wheel, spin)] = state_[at(wheel, bend_x)] = state_[at(wheel, bend_y)] = 0.0;
}

void Plant::write_output(const PlantInput& input) {
  const Derivative d = derivative(state_, input);
  output_ = {.x = state_[pos_x],
             .y = state_[pos_y],
             .yaw = state_[heading],
             .v_x = state_[vel_x],
             .v_y = state_[vel_y],
             .yaw_rate = state_[rate],
             .accel_x = d.accel_x,
             .accel_y = d.accel_y,
             .yaw_accel = d.rate[rate],
             .steering = state_[steer],
             .commanded_steering = input.steering,
             .wheel_angle = {},
             .wheel_rate = {},
             .roll = state_[roll],
             .pitch = state_[pitch],
             .roll_rate = state_[roll_rate],
             .pitch_rate = state_[pitch_rate],
             .roll_accel = d.rate[roll_rate],
             .pitch_accel = d.rate[pitch_rate],
             .grade = road_.grade,
             .bank = road_.bank,
             .grade_rate = road_.grade_rate,
             .bank_rate = road_.bank_rate};
  for (std::size_t wheel = 0; wheel < wheel_count; ++wheel) {
    output_.wheel_angle[wheel] = state_[at(wheel, turned)];
    output_.wheel_rate[wheel] = state_[at(wheel, spin)];
  }
}

void Plant::set_speed(double v_x) {
  motion_ = Movement::rolling;
  state_[vel_x] = v_x;
  for (std::size_t wheel = 0; wheel < wheel_count; ++wheel)
    state_[at(wheel, spin)] = v_x / parameters_.wheel_radius[wheel];
  write_output({});
}

}  // namespace odomd::sim
