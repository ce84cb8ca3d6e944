#include "tools/sim/course/power_slide.hpp"

#include <algorithm>
#include <cmath>

namespace odomd::sim {
namespace {

constexpr double sideslip_gain = 5.0, yaw_gain = 25.0;  // [1/s]
constexpr double throttle_gain = 0.7;                   // of the mass [1/s]
constexpr double used_grip = 0.85;                      // of μ g, by the centripetal acceleration

/// What the tyres are to do to the car, in its axes [N].
struct AxleForces {
  double front_limit = 0.0, rear_limit = 0.0;  ///< μ F_z
  double front_y = 0.0, rear_y = 0.0;
};

// The path turns by ν̇, faster the more the speed exceeds the curve's. With β̇ = ν̇ - ψ̇ the yaw rate
// is to be ψ̇ = ν̇ - k (β_target - β). The yaw moment for it, J ψ̈ = l_v F_v - l_h F_h, comes from
// the front axle as far as that grips; beyond, the rear axle gives up lateral force.
AxleForces wanted_forces(const PlantParameters& car, const PlantOutput& now,
                         const SlideTarget& target) {
  const double grip = car.friction * standard_gravity;
  const double speed = std::hypot(now.v_x, now.v_y);
  const double sideslip = std::atan2(now.v_y, now.v_x);
  const double curve_speed = std::sqrt(used_grip * grip / std::abs(target.curvature));
  const double part = std::clamp(used_grip + speed / curve_speed - 1.0, 0.7, 0.95);
  const double centripetal = std::copysign(part * grip, target.curvature);
  const double yaw_rate = centripetal / speed - sideslip_gain * (target.sideslip - sideslip);
  const double moment = car.yaw_inertia * yaw_gain * (yaw_rate - now.yaw_rate);

  const double rear_share = car.front_axle / (car.front_axle + car.rear_axle);
  const double lateral = car.mass * centripetal * std::cos(sideslip);
  AxleForces result{.front_limit = (1.0 - rear_share) * car.mass * grip,
                    .rear_limit = rear_share * car.mass * grip};
  const double steady = (1.0 - rear_share) * lateral;
  const double most = 0.9 * result.front_limit;
  result.front_y = std::clamp(steady + moment / car.front_axle, -most, most);
  const double rest = moment - car.front_axle * (result.front_y - steady);
  result.rear_y = rear_share * lateral - rest / car.rear_axle;
  return result;
}

// δ = angle of the front axle's motion + α, with α from F = μ F_z sin(c atan(s / c)),
// s = C α / (μ F_z)
double steering(const PlantParameters& car, const PlantOutput& now, const AxleForces& force) {
  const double motion = std::atan2(now.v_y + car.front_axle * now.yaw_rate, now.v_x);
  const double c = car.tyre_shape;
  const double s = c * std::tan(std::asin(force.front_y / force.front_limit) / c);
  const double slip_angle = s * force.front_limit / car.cornering_stiffness_front;
  return std::clamp(motion + slip_angle, -car.steering_limit, car.steering_limit);
}

// The rear axle slides: its force lies on the friction circle, and its slips are in the ratio of
// their forces: κ / tan α = (F_x / C_κ) / (F_y / C_α). The throttle holds the wheel speed of κ.
double throttle(const PlantParameters& car, const PlantOutput& now, const SlideTarget& target,
                const AxleForces& force) {
  const double inwards = std::copysign(force.rear_y, force.rear_y * target.curvature);
  const double part = std::clamp(inwards / (0.97 * force.rear_limit), 0.05, 1.0);
  const double ratio = std::sqrt(1.0 / (part * part) - 1.0);  // F_x / F_y
  const double forward = std::max(now.v_x, 0.1);
  const double tan_slip = std::abs(now.v_y - car.rear_axle * now.yaw_rate) / forward;
  const double slip = std::min(0.7, tan_slip * ratio / car.slip_stiffness_ratio);
  const double tread = 0.5 * (now.wheel_rate[rear_left] * car.wheel_radius[rear_left] +
                              now.wheel_rate[rear_right] * car.wheel_radius[rear_right]);
  return 0.97 * force.rear_limit * part * ratio +
         throttle_gain * car.mass * (forward / (1.0 - slip) - tread);
}

}  // namespace

PlantInput hold_slide(const PlantParameters& car, const PlantOutput& now,
                      const SlideTarget& target) {
  const AxleForces force = wanted_forces(car, now, target);
  return {.steering = steering(car, now, force), .force = throttle(car, now, target, force)};
}

}  // namespace odomd::sim
