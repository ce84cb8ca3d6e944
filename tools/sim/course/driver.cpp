#include "tools/sim/course/driver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace odomd::sim {
namespace {

// The input for a car with rear-wheel drive that slides through a curve. The throttle spins the
// rear wheels, which uses up their grip. The front wheels, turned against the curve, hold the
// sideslip angle β_target, whose sign is opposite to the curve's.
PlantInput hold_slide(const PlantParameters& car, const PlantOutput& now, double target,
                      double curvature) {
  constexpr double sideslip_gain = 5.0, yaw_gain = 25.0;  // [1/s]
  constexpr double throttle_gain = 0.7;                   // force / (mass · speed error) [1/s]
  constexpr double used_grip = 0.85;  // share of μ g for the centripetal acceleration

  // The course rate ν̇ grows with speed / curve speed. With β̇ = ν̇ - ψ̇ the required yaw rate is
  // ψ̇ = ν̇ - k (β_target - β).
  const double grip = car.friction * standard_gravity;
  const double speed = std::hypot(now.v_x, now.v_y);
  const double sideslip = std::atan2(now.v_y, now.v_x);
  const double curve_speed = std::sqrt(used_grip * grip / std::abs(curvature));
  const double course_part = std::clamp(used_grip + speed / curve_speed - 1.0, 0.7, 0.95);
  const double centripetal = std::copysign(course_part * grip, curvature);
  const double yaw_rate = centripetal / speed - sideslip_gain * (target - sideslip);
  const double moment = car.yaw_inertia * yaw_gain * (yaw_rate - now.yaw_rate);

  // The front axle supplies the yaw moment, J ψ̈ = l_v F_v - l_h F_h, as far as its grip allows;
  // for the rest the rear axle reduces its lateral force.
  const double rear_share = car.front_axle / (car.front_axle + car.rear_axle);
  const double front_limit = (1.0 - rear_share) * car.mass * grip;  // μ F_z
  const double rear_limit = 0.97 * (rear_share * car.mass * grip);
  const double lateral = car.mass * centripetal * std::cos(sideslip);
  const double steady = (1.0 - rear_share) * lateral;
  const double front_y =
      std::clamp(steady + moment / car.front_axle, -0.9 * front_limit, 0.9 * front_limit);
  const double rest = moment - car.front_axle * (front_y - steady);
  const double rear_y = rear_share * lateral - rest / car.rear_axle;

  // δ = angle of the front axle's motion + α, with α from F = μ F_z sin(c atan(s / c)),
  // s = C α / (μ F_z)
  const double motion = std::atan2(now.v_y + car.front_axle * now.yaw_rate, now.v_x);
  const double c = car.tyre_shape;
  const double s = c * std::tan(std::asin(front_y / front_limit) / c);
  const double slip_angle = s * front_limit / car.cornering_stiffness_front;

  // The rear axle slides: its force is on the friction circle, and its slips are in the ratio κ /
  // tan α = (F_x / C_κ) / (F_y / C_α). The throttle keeps the wheel speed that gives κ.
  const double inwards = std::copysign(rear_y, rear_y * curvature);
  const double part = std::clamp(inwards / rear_limit, 0.05, 1.0);
  const double ratio = std::sqrt(1.0 / (part * part) - 1.0);  // F_x / F_y
  const double forward = std::max(now.v_x, 0.1);
  const double tan_slip = std::abs(now.v_y - car.rear_axle * now.yaw_rate) / forward;
  const double slip = std::min(0.7, tan_slip * ratio / car.slip_stiffness_ratio);
  const double tread = 0.5 * (now.wheel_rate[rear_left] * car.wheel_radius[rear_left] +
                              now.wheel_rate[rear_right] * car.wheel_radius[rear_right]);
  return {.steering = std::clamp(motion + slip_angle, -car.steering_limit, car.steering_limit),
          .force = rear_limit * part * ratio +
                   throttle_gain * car.mass * (forward / (1.0 - slip) - tread)};
}

// Distance to the end at which the car has arrived [m].
constexpr double arrived = 0.002;

double gear_sign(Gear gear) {
  return gear == Gear::forward ? 1.0 : -1.0;
}

// v²(s) that keeps the lateral limit in curves and brakes for them in time: a backward pass, or two
// if the track is closed.
std::vector<double> plan_speed(const Leg& leg, const DriverLimits& limits) {
  const std::vector<TrackPoint>& samples = leg.track->samples();
  std::vector<double> v2(samples.size());
  for (std::size_t i = 0; i < v2.size(); ++i) {
    const double curvature = std::max(std::abs(samples[i].curvature), 1e-6);
    v2[i] = std::min(leg.speed * leg.speed, limits.lateral / curvature);
  }
  const double gain = 2.0 * limits.deceleration * leg.track->step();
  const int passes = leg.track->shape() == Shape::closed ? 2 : 1;
  for (int pass = 0; pass < passes; ++pass) {
    if (passes == 2) v2.back() = v2.front();
    for (std::size_t i = v2.size() - 1; i-- > 0;) v2[i] = std::min(v2[i], v2[i + 1] + gain);
  }
  return v2;
}

}  // namespace

TrackPoint standing_pose(const PlantParameters& car, const Leg& leg) {
  TrackPoint p = leg.track->at(leg.begin);
  if (leg.gear == Gear::reverse) p.heading += std::numbers::pi;
  p.x += car.rear_axle * std::cos(p.heading);
  p.y += car.rear_axle * std::sin(p.heading);
  return p;
}

Driver::Driver(PlantParameters car, std::vector<Leg> legs, const DriverLimits& limits, double wait,
               Ends ends)
    : car_(std::move(car)),
      legs_(std::move(legs)),
      limits_(limits),
      ends_(ends),
      wait_(ends == Ends::moving ? 0.0 : wait) {
  for (const Leg& leg : legs_) total_ += leg.end - leg.begin;
  begin_leg();
  wanted_speed_ = start_speed();
}

void Driver::begin_leg() {
  wanted_speed_ = 0.0;
  if (leg_ == legs_.size()) return;
  s_ = legs_[leg_].begin;
  plan_ = plan_speed(legs_[leg_], limits_);
}

double Driver::planned_speed(double s) const {
  const Leg& leg = legs_[leg_];
  const double remaining =
      ends_ == Ends::moving ? std::numeric_limits<double>::infinity() : leg.end - s;
  if (remaining <= arrived) return 0.0;
  double on_track = s;
  if (leg.track->shape() == Shape::closed)
    on_track -= std::floor(s / leg.track->length()) * leg.track->length();
  const double sample = std::max(0.0, on_track / leg.track->step());
  const std::size_t i = std::min(static_cast<std::size_t>(sample), plan_.size() - 1);
  // v² = 2 a s to the stop
  return std::sqrt(std::min(plan_[i], 2.0 * limits_.deceleration * remaining));
}

// Path following at the rear axle. With e the lateral error and θ the course error, both seen in
// the direction of travel, and κ_c the commanded curvature:  e' = sin θ,  θ' = κ_c - κ  per metre.
// Then
//   κ_c = κ - e / λ² - 2 sin θ / λ
// makes the loop critically damped with the length λ, forward and in reverse.
double Driver::path_curvature(const PlantOutput& car, Vector2 rear, double curvature,
                              double reach) const {
  const TrackPoint here = legs_[leg_].track->at(s_);
  const double e =
      (rear.y - here.y) * std::cos(here.heading) - (rear.x - here.x) * std::sin(here.heading);
  double course = car.yaw + (legs_[leg_].gear == Gear::reverse ? std::numbers::pi : 0.0);
  if (std::abs(car.v_x) > 2.0 * (car_.front_axle + car_.rear_axle))
    course += std::atan((car.v_y - car_.rear_axle * car.yaw_rate) / car.v_x);
  return curvature - std::clamp(e, -reach, reach) / (reach * reach) -
         2.0 * std::sin(course - here.heading) / reach;
}

// ±tan δ = l κ_c; driving forward, with the understeer of linear tyres,
// δ += (m/l)(l_h/C_v - l_v/C_h) a_y.
double Driver::steering(const PlantOutput& car, Vector2 rear) const {
  const Leg& leg = legs_[leg_];
  const double wheelbase = car_.front_axle + car_.rear_axle;
  const double speed = std::abs(car.v_x);
  const double preview = (car_.steering_delay + car_.steering_lag + 0.07) * speed;
  const double curvature = leg.track->at(s_ + preview).curvature;
  const double reach = std::max(1.5 * wheelbase, limits_.horizon * speed);
  const double commanded = path_curvature(car, rear, curvature, reach);
  const double understeer = car_.mass / wheelbase *
                            (car_.rear_axle / car_.cornering_stiffness_front -
                             car_.front_axle / car_.cornering_stiffness_rear);
  const double extra = leg.gear == Gear::forward ? understeer * speed * speed * curvature : 0.0;
  return std::clamp(gear_sign(leg.gear) * std::atan(wheelbase * commanded) + extra,
                    -car_.steering_limit, car_.steering_limit);
}

// A slide begins shortly before a curve if the car is fast enough, and ends before the curve does.
// The sideslip angle is ramped; normal driving resumes once the car grips again.
std::optional<PlantInput> Driver::slide(const PlantOutput& car, Vector2 rear, double dt) {
  const Leg& leg = legs_[leg_];
  if (leg.slide == 0.0) return std::nullopt;
  constexpr double begin = 0.3, end = 0.6;    // times before the curve begins and ends [s]
  constexpr double ramp = 3.0, grips = 0.3;   // [rad/s], [rad]
  constexpr double quick = 0.4, reach = 3.0;  // lateral acceleration / μ g; length λ [m]
  const double speed = std::hypot(car.v_x, car.v_y);
  const double near = leg.track->at(s_ + begin * speed).curvature;
  const double far = leg.track->at(s_ + end * speed).curvature;
  const double curvature = std::abs(near) < std::abs(far) ? near : far;
  double sideslip = 0.0;
  if (speed * speed * std::abs(curvature) > quick * car_.friction * standard_gravity) {
    slide_curvature_ = curvature;
    sideslip = -std::copysign(leg.slide, curvature);
  }
  sideslip_ += std::clamp(sideslip - sideslip_, -ramp * dt, ramp * dt);
  if (sideslip_ == 0.0 && std::abs(std::atan2(car.v_y, car.v_x)) < grips) return std::nullopt;

  // Limited to about the curve's curvature: during a slide, its sign must not change.
  const double corrected = path_curvature(car, rear, slide_curvature_, reach) / slide_curvature_;
  return hold_slide(car_, car, sideslip_, slide_curvature_ * std::clamp(corrected, 0.5, 1.5));
}

PlantInput Driver::drive(const PlantOutput& car, double dt) {
  const bool standing = car.v_x == 0.0;
  if (waited_ < wait_ || leg_ == legs_.size()) {
    waited_ += dt;
    return {.steering = steering_, .force = standing ? 0.0 : -2.0 * car_.mass * car.v_x};
  }
  const Leg& leg = legs_[leg_];
  const double sign = gear_sign(leg.gear);
  const Vector2 rear{car.x - car_.rear_axle * std::cos(car.yaw),
                     car.y - car_.rear_axle * std::sin(car.yaw)};
  s_ = leg.track->nearest(rear.x, rear.y, s_);
  const TrackPoint foot = leg.track->at(s_);
  off_track_ = std::hypot(rear.x - foot.x, rear.y - foot.y);
  if (ends_ == Ends::moving ? s_ >= leg.end : standing && leg.end - s_ <= arrived) {
    finished_ += leg.end - leg.begin;
    wait_ = ends_ == Ends::moving ? 0.0 : leg.pause;
    waited_ = 0.0;
    ++leg_;
    begin_leg();
    return {.steering = steering_, .force = 0.0};
  }
  if (const auto input = slide(car, rear, dt)) {
    wanted_speed_ = car.v_x;
    steering_ = input->steering;
    return *input;
  }
  steering_ = steering(car, rear);

  // The planned speed one drive lag ahead; only increases are ramped.
  const double speed = sign * car.v_x;
  const double planned = planned_speed(s_ + car_.drive_lag * std::max(speed, 0.0));
  const double before = wanted_speed_;
  wanted_speed_ = std::min(planned, wanted_speed_ + limits_.acceleration * dt);
  const double ramp = std::max((wanted_speed_ - before) / dt, -1.5 * limits_.deceleration);
  const double rolling = planned > 0.0 ? car_.rolling_resistance * 9.81 : 0.0;
  const double wanted_accel = std::clamp(ramp + 8.0 * (wanted_speed_ - speed) + rolling,
                                         -2.0 * limits_.deceleration, 2.0 * limits_.acceleration);
  return {.steering = steering_,
          .force = sign * (car_.mass * wanted_accel + car_.drag * speed * speed)};
}

}  // namespace odomd::sim
