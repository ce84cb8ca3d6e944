#include "tools/sim/plant.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace odomd::sim {
namespace {

constexpr double gravity = 9.80665;

// Where things lie in the state.
enum : std::size_t {
  pos_x,
  pos_y,
  heading,
  vel_x,
  vel_y,
  rate,
  steer,
  drive,
  shift_x,
  shift_y,
  roll,
  roll_rate,
  pitch,
  pitch_rate,
  wheels_begin
};
enum : std::size_t { spin, turned, bend_x, bend_y };

constexpr std::size_t at(std::size_t wheel, std::size_t what) {
  return wheels_begin + 4 * wheel + what;
}

struct Vector2 {
  double x = 0.0, y = 0.0;
};

Vector2 rotate(Vector2 v, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * v.x - s * v.y, s * v.x + c * v.y};
}

Vector2 wheel_position(const PlantParameters& p, std::size_t wheel) {
  const double side = wheel % 2 == 0 ? 0.5 : -0.5;  // left wheels have even numbers
  const double wider = (wheel < rear_left ? 0.5 : -0.5) * p.track_difference;
  return {wheel < rear_left ? p.front_axle : -p.rear_axle, side * (p.track_width + wider)};
}

// Ackermann: both front wheels point across the same centre of the turn,
//   tan δ_i = l tan δ / (l - y_i tan δ)
double wheel_steering(const PlantParameters& p, std::size_t wheel, double steering) {
  if (wheel >= rear_left) return 0.0;
  const double l = p.front_axle + p.rear_axle, t = std::tan(steering);
  return std::atan2(l * t, l - wheel_position(p, wheel).y * t);
}

// How a tyre moves over the ground, in its own axes.
struct WheelMotion {
  double steering = 0.0;
  double v_x = 0.0;          // of the hub
  double slide_x = 0.0;      // of the contact: hub less tread, V_sx
  double slide_y = 0.0;      // V_sy
  double transport_x = 0.0;  // speed at which the contact renews itself, for each direction
  double transport_y = 0.0;
  double slip_x = 0.0;  // κ, tan α that the tyre feels
  double slip_y = 0.0;
};

// Single-contact-point tyre with relaxation (Pacejka, ch. 7): the deflections u, v obey
//   u̇ = -V_sx - V_t u / σ_κ,   κ = u / σ_κ;      v̇ = -V_sy - V_t v / σ_α,   tan α = v / σ_α
// They hold through standstill, where they are springs; there, and only there, damped.
// V_t is the faster of hub and tread, and bounds the slips at 2 where a tyre slides without
// rolling.
template <class State>
WheelMotion wheel_motion(const PlantParameters& p, const State& s, std::size_t wheel) {
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
  // Faded out while it is still small against the relaxation: a few percent of the stiffness.
  const double fade_speed = 0.2 * p.relaxation_length / p.tyre_damping;
  const double damping =
      rolling < fade_speed
          ? 0.5 * p.tyre_damping * (1.0 + std::cos(std::numbers::pi * rolling / fade_speed))
          : 0.0;
  motion.slip_x = (s[at(wheel, bend_x)] - 0.2 * damping * motion.slide_x) / length_x;
  motion.slip_y = (s[at(wheel, bend_y)] - damping * motion.slide_y) / length_y;
  return motion;
}

// What part of the wanted torque a wheel gets. A drive fades near its top speed, and a brake holds
// a wheel that it has stopped.
enum class Pedal : std::uint8_t { drive, brake };
double torque_part(const PlantParameters& p, Pedal pedal, double v_x, double tread, double force) {
  if (pedal == Pedal::brake)
    return std::clamp(std::copysign(1.0, v_x) * tread / p.walking_speed(), -1.0, 1.0);
  const double spinning = std::copysign(1.0, force) * tread;
  return std::clamp(5.0 * (1.0 - spinning / p.top_speed), 0.0, 1.0);
}

template <class State>
Attitude attitude(const State& s) {
  return {
      .roll = s[roll], .roll_rate = s[roll_rate], .pitch = s[pitch], .pitch_rate = s[pitch_rate]};
}

// Of a wheel with its share of the motor.
double spin_inertia(const PlantParameters& p, std::size_t wheel) {
  const double share = wheel < rear_left ? p.drive_front_share : 1.0 - p.drive_front_share;
  return p.wheel_inertia + share * p.motor_inertia;
}

void require(bool holds, const std::string& what) {
  if (!holds) throw std::invalid_argument("vehicle of the simulation: " + what);
}

}  // namespace

PlantOutput interpolate(const PlantOutput& from, const PlantOutput& to, double part) {
  using Numbers = std::array<double, sizeof(PlantOutput) / sizeof(double)>;
  auto a = std::bit_cast<Numbers>(from);
  const auto b = std::bit_cast<Numbers>(to);
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += part * (b[i] - a[i]);
  return std::bit_cast<PlantOutput>(a);
}

BodyForce specific_force_at(const PlantOutput& o, double x, double y, double z) {
  // a(p) = a + ψ̈ × p - ψ̇² p: Euler and centripetal terms of the lever arm
  if (o.is_level())
    return {o.accel_x - o.yaw_accel * y - o.yaw_rate * o.yaw_rate * x,
            o.accel_y + o.yaw_accel * x - o.yaw_rate * o.yaw_rate * y};

  // f = a + g n on the road, seen from the body, R = R_y(θ) R_x(φ)
  const Up up = up_on({.grade = o.grade, .bank = o.bank});
  const double f_x = o.accel_x + gravity * up.x;
  const double f_y = o.accel_y + gravity * up.y;
  const double f_z = gravity * up.z;
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

// ω_z = ψ̇ cos θ cos φ - θ̇ sin φ, with the angles of the body against the horizon
double body_yaw_rate(const PlantOutput& o) {
  if (o.is_level()) return o.yaw_rate;
  const double over_roll = o.roll + o.bank, over_pitch = o.pitch - o.grade;
  return o.yaw_rate * std::cos(over_pitch) * std::cos(over_roll) -
         (o.pitch_rate - o.grade_rate) * std::sin(over_roll);
}

Plant::Plant(PlantParameters parameters, double x, double y, double yaw)
    : parameters_(std::move(parameters)) {
  const PlantParameters& p = parameters_;
  for (const double positive : {p.mass,
                                p.front_axle,
                                p.rear_axle,
                                p.yaw_inertia,
                                p.track_width,
                                p.cornering_stiffness_front,
                                p.cornering_stiffness_rear,
                                p.slip_stiffness_ratio,
                                p.tyre_shape,
                                p.relaxation_length,
                                p.tyre_damping,
                                p.friction,
                                p.wheel_inertia,
                                p.load_lag,
                                p.drive_lag,
                                p.steering_lag,
                                p.steering_rate_limit,
                                p.steering_limit,
                                p.rest_speed,
                                p.top_speed})
    require(positive > 0.0, "masses, lengths, stiffnesses, lags and limits must be positive");
  for (const double radius : p.wheel_radius) require(radius > 0.0, "wheel radii must be positive");
  require(p.tyre_shape <= 2.0, "tyre_shape must not exceed 2");

  // F_z0 of the front axle = m g l_h / l
  const double wheelbase = p.front_axle + p.rear_axle;
  for (std::size_t wheel = 0; wheel < wheel_count; ++wheel) {
    const bool front = wheel < rear_left;
    const double stiffness =
        0.5 * (front ? p.cornering_stiffness_front : p.cornering_stiffness_rear);
    const double arm = front ? p.rear_axle : p.front_axle;
    tyres_[wheel] = {.cornering_stiffness = stiffness,
                     .slip_stiffness = p.slip_stiffness_ratio * stiffness,
                     .nominal_load = 0.5 * p.mass * gravity * arm / wheelbase,
                     .shape = p.tyre_shape,
                     .load_exponent = p.tyre_load_exponent};
  }
  state_[pos_x] = x;
  state_[pos_y] = y;
  state_[heading] = yaw;
  write_output({});
}

// Static load, plus what a_x moves to the rear and a_y to the outer wheels:
//   ΔF_z = m a_x h / l per axle,   ΔF_z = m a_y h / w, shared between the axles by roll stiffness
std::array<double, wheel_count> Plant::loads(const State& s) const {
  const PlantParameters& p = parameters_;
  std::array<double, wheel_count> result{};
  if (p.suspension.present()) {
    const Tracks tracks{.wheelbase = p.front_axle + p.rear_axle,
                        .front = p.track_width + 0.5 * p.track_difference,
                        .rear = p.track_width - 0.5 * p.track_difference};
    const LoadShift shift =
        load_shift(p.suspension, p.mass, attitude(s), tracks, s[shift_x], s[shift_y]);
    const double upright = up_on(road_).z;
    for (std::size_t wheel = 0; wheel < wheel_count; ++wheel) {
      const bool front = wheel < rear_left;
      const double along = front ? -0.5 * shift.to_rear : 0.5 * shift.to_rear;
      const double across = front ? shift.front_to_right : shift.rear_to_right;
      result[wheel] = std::max(
          0.0, tyres_[wheel].nominal_load * upright + along + (wheel % 2 == 0 ? -across : across));
    }
    return result;
  }
  const double along = p.mass * s[shift_x] * p.centre_height / (p.front_axle + p.rear_axle);
  const double across = p.mass * s[shift_y] * p.centre_height / p.track_width;
  for (std::size_t wheel = 0; wheel < wheel_count; ++wheel) {
    const bool front = wheel < rear_left;
    const double share = front ? p.roll_front_share : 1.0 - p.roll_front_share;
    const double to_the_rear = front ? -0.5 * along : 0.5 * along;
    const double to_the_right = wheel % 2 == 0 ? -share * across : share * across;
    result[wheel] = std::max(0.0, tyres_[wheel].nominal_load + to_the_rear + to_the_right);
  }
  return result;
}

double Plant::friction_at(double x, double y) const {
  for (const FrictionPatch& patch : parameters_.patches)
    if (std::hypot(x - patch.x, y - patch.y) <= patch.radius) return patch.friction;
  return parameters_.friction;
}

double Plant::breakaway_force() const {
  return parameters_.rolling_resistance * parameters_.mass * gravity;
}

// What wheels and air do to the car, and in `d` what becomes of the wheels.
Plant::GroundForces Plant::wheel_forces(const State& s, State& d) const {
  const PlantParameters& p = parameters_;
  const std::array<double, wheel_count> load = loads(s);
  const Pedal pedal = s[drive] * s[vel_x] < 0.0 && std::abs(s[vel_x]) > p.walking_speed()
                          ? Pedal::brake
                          : Pedal::drive;
  GroundForces force{.x = -p.drag * s[vel_x] * std::abs(s[vel_x])};
  for (std::size_t wheel = 0; wheel < wheel_count; ++wheel) {
    const bool front = wheel < rear_left;
    const double radius = p.wheel_radius[wheel];
    const WheelMotion motion = wheel_motion(p, s, wheel);
    const Vector2 place = wheel_position(p, wheel);
    const Vector2 ahead = rotate(place, s[heading]);
    const double friction = friction_at(s[pos_x] + ahead.x, s[pos_y] + ahead.y);
    const TyreForce tyre =
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
    d[at(wheel, spin)] = (torque - radius * tyre.x) / spin_inertia(p, wheel);
    d[at(wheel, turned)] = s[at(wheel, spin)];
    d[at(wheel, bend_x)] =
        -motion.slide_x - motion.transport_x * s[at(wheel, bend_x)] / (0.5 * p.relaxation_length);
    d[at(wheel, bend_y)] =
        -motion.slide_y - motion.transport_y * s[at(wheel, bend_y)] / p.relaxation_length;
  }
  return force;
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
  if (motion_ == Motion::rolling) {
    const GroundForces force = wheel_forces(s, d);
    body = sprung ? body_acceleration(p.suspension, p.mass, attitude(s), road_, force.x, force.y)
                  : BodyAcceleration{.x = force.x / p.mass, .y = force.y / p.mass};
    // v̇_x = a_x + v_y ψ̇,  v̇_y = a_y - v_x ψ̇
    d[vel_x] = body.x + s[vel_y] * s[rate];
    d[vel_y] = body.y - s[vel_x] * s[rate];
    d[rate] = force.moment / p.yaw_inertia;
    // What a map shows of a way uphill or across a bank is shorter.
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
  d[shift_x] = (result.accel_x + gravity * up.x - s[shift_x]) / p.load_lag;
  d[shift_y] = (result.accel_y + gravity * up.y - s[shift_y]) / p.load_lag;
  return result;
}

// Classic Runge-Kutta of fourth order.
void Plant::step(const PlantInput& wanted, double dt) {
  PlantInput input = wanted;
  input.steering = delayed(wanted.steering, dt);
  if (parameters_.suspension.present()) road_ = wanted.road;
  const auto moved = [this](const Derivative& k, double h) {
    State result = state_;
    for (std::size_t i = 0; i < state_count; ++i) result[i] += h * k.rate[i];
    return result;
  };
  const Derivative k1 = derivative(state_, input);
  const Derivative k2 = derivative(moved(k1, 0.5 * dt), input);
  const Derivative k3 = derivative(moved(k2, 0.5 * dt), input);
  const Derivative k4 = derivative(moved(k3, dt), input);
  for (std::size_t i = 0; i < state_count; ++i)
    state_[i] += dt / 6.0 * (k1.rate[i] + 2.0 * k2.rate[i] + 2.0 * k3.rate[i] + k4.rate[i]);
  come_to_rest_or_go();
  write_output(input);
  output_.commanded_steering = wanted.steering;
}

// The command of `steering_delay` ago; before the first there was none.
double Plant::delayed(double steering, double dt) {
  const auto steps = static_cast<std::size_t>(std::lround(parameters_.steering_delay / dt));
  if (steps == 0) return steering;
  commands_.push_back(steering);
  if (commands_.size() <= steps) return 0.0;
  const double then = commands_.front();
  commands_.pop_front();
  return then;
}

// Static friction: slower than rest_speed everywhere and undriven, the car stands, exactly; it
// goes again when the drive overcomes the rolling resistance.
void Plant::come_to_rest_or_go() {
  const PlantParameters& p = parameters_;
  const bool driven = std::abs(state_[drive]) > breakaway_force();
  if (driven) {
    motion_ = Motion::rolling;
    return;
  }
  if (motion_ == Motion::resting) return;
  double fastest = std::max({std::abs(state_[vel_x]), std::abs(state_[vel_y]),
                             std::abs(state_[rate]) * (p.front_axle + p.rear_axle)});
  for (std::size_t wheel = 0; wheel < wheel_count; ++wheel)
    fastest = std::max(fastest, std::abs(p.wheel_radius[wheel] * state_[at(wheel, spin)]));
  if (fastest > p.rest_speed) return;
  motion_ = Motion::resting;
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
  for (std::size_t wheel = 0; wheel < wheel_count; ++wheel)
    output_.wheel_angle[wheel] = state_[at(wheel, turned)];
}

std::array<double, wheel_count> Plant::loads() const {
  return loads(state_);
}

std::array<double, wheel_count> Plant::slip_x() const {
  std::array<double, wheel_count> result{};
  for (std::size_t wheel = 0; wheel < wheel_count; ++wheel)
    result[wheel] = wheel_motion(parameters_, state_, wheel).slip_x;
  return result;
}

std::array<double, wheel_count> Plant::slip_y() const {
  std::array<double, wheel_count> result{};
  for (std::size_t wheel = 0; wheel < wheel_count; ++wheel)
    result[wheel] = wheel_motion(parameters_, state_, wheel).slip_y;
  return result;
}

void Plant::set_speed(double v_x) {
  motion_ = Motion::rolling;
  state_[vel_x] = v_x;
  for (std::size_t wheel = 0; wheel < wheel_count; ++wheel)
    state_[at(wheel, spin)] = v_x / parameters_.wheel_radius[wheel];
  write_output({});
}

double Plant::kinetic_energy() const {
  const PlantParameters& p = parameters_;
  double energy = 0.5 * p.mass * (state_[vel_x] * state_[vel_x] + state_[vel_y] * state_[vel_y]) +
                  0.5 * p.yaw_inertia * state_[rate] * state_[rate];
  for (std::size_t wheel = 0; wheel < wheel_count; ++wheel) {
    energy += 0.5 * spin_inertia(p, wheel) * state_[at(wheel, spin)] * state_[at(wheel, spin)];
  }
  return energy;
}

}  // namespace odomd::sim
