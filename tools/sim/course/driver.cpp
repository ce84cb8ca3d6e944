#include "tools/sim/course/driver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace odomd::sim {
namespace {

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
// makes the loop critically damped with the length λ, forward and in reverse. The steering is
// ±tan δ = l κ_c; driving forward, with the understeer of linear tyres,
// δ += (m/l)(l_h/C_v - l_v/C_h) a_y.
double Driver::steering(const PlantOutput& car, Vector2 rear) const {
  const Leg& leg = legs_[leg_];
  const double wheelbase = car_.front_axle + car_.rear_axle;
  const double speed = std::abs(car.v_x);
  const double preview = (car_.steering_delay + car_.steering_lag + 0.07) * speed;
  const double curvature = leg.track->at(s_ + preview).curvature;
  const double reach = std::max(1.5 * wheelbase, limits_.horizon * speed);
  const TrackPoint here = leg.track->at(s_);
  const double e =
      (rear.y - here.y) * std::cos(here.heading) - (rear.x - here.x) * std::sin(here.heading);
  double course = car.yaw + (leg.gear == Gear::reverse ? std::numbers::pi : 0.0);
  if (speed > 2.0 * wheelbase)
    course += std::atan((car.v_y - car_.rear_axle * car.yaw_rate) / car.v_x);
  const double commanded = curvature - std::clamp(e, -reach, reach) / (reach * reach) -
                           2.0 * std::sin(course - here.heading) / reach;
  const double understeer = car_.mass / wheelbase *
                            (car_.rear_axle / car_.cornering_stiffness_front -
                             car_.front_axle / car_.cornering_stiffness_rear);
  const double extra = leg.gear == Gear::forward ? understeer * speed * speed * curvature : 0.0;
  return std::clamp(gear_sign(leg.gear) * std::atan(wheelbase * commanded) + extra,
                    -car_.steering_limit, car_.steering_limit);
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
