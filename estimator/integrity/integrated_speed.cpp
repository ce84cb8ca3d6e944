// docs/model.md, "Integrity".
#include "estimator/integrity/equations.hpp"

#include <algorithm>
#include <cmath>

#include "estimator/common/symmetric3.hpp"
#include "estimator/common/time.hpp"
#include "estimator/common/vehicle.hpp"

namespace odomd::estimator::integrity {
namespace {

// Time constant for tracking the consensus [s].
constexpr double follow_s = 0.3;

/// Locked wheels brake, which the accelerometer measures. So the car stands if all wheels are
/// distrusted and neither accelerometer, gyro nor camera has shown any motion for a while.
void stop_with_locked_wheels(Observations& observed, bool wheels_distrusted) noexcept {
  constexpr double stands_after_s = 2.0;
  constexpr double braking = 0.05;        // [g]
  constexpr double standing_sigma = 0.1;  // [m/s]
  const double accel = observed.history(Source::accel_x).mean(Over::long_time);
  bool still = wheels_distrusted && is_steady(observed.history(Source::yaw_rate)) &&
               std::abs(accel - observed.accel_offset) < braking * gravity &&
               !observed.camera_speed.alive(observed.now_ns);
  for (const Source source : wheel_sources) {
    const SourceHistory& wheel = observed.history(source);
    still = still && (!wheel.alive(observed.now_ns) || std::abs(wheel.mean()) < slowest_turning);
  }
  if (!still) {
    observed.still_since_ns = observed.now_ns;
  } else if (seconds_between(observed.still_since_ns, observed.now_ns) >= stands_after_s) {
    observed.integrated_speed = 0.0;
    observed.integrated_sigma = standing_sigma;
  }
}

}  // namespace

/// v̇_x = a_x + v_y ψ̇, v_y = l_h ψ̇ + the rear axle's slip.
void integrate_acceleration(const Sensors& sensors, Observations& observed, double dt,
                            bool wheels_distrusted) noexcept {
  constexpr double sliding_share = 0.5;  // v_y / v of a sliding car
  if (!observed.usable(Source::accel_x)) {
    observed.integrated_sigma += gravity * dt;
    return;
  }
  const SourceHistory& accel_x = observed.history(Source::accel_x);
  const double yaw_rate = observed.yaw_rate();
  const double by_turn = sensors.car.rear_axle * yaw_rate * yaw_rate;
  const double by_slip = observed.errors.rear_slip * yaw_rate;
  const double v_x_dot = accel_x.mean() - observed.accel_offset + by_turn + by_slip;
  observed.integrated_speed += v_x_dot * dt;
  const double sideways = observed.slides(observed.now_ns)
                              ? sliding_share * observed.speed() * yaw_rate
                              : by_turn + std::abs(by_slip);
  observed.integrated_sigma +=
      dt * std::sqrt(squared(observed.accel_offset_sigma) +
                     squared(accel_x.sigma) * accel_x.cycle_s / follow_s +
                     squared(sensors.tuning.pitch_gradient * v_x_dot) + squared(sideways));
  stop_with_locked_wheels(observed, wheels_distrusted);
}

void follow_consensus(Observations& observed, double dt, bool contradicted, bool learns) noexcept {
  constexpr double slope_s = 20.0;
  constexpr double least_slope = 0.02;  // [g], smallest sigma of the offset
  constexpr double contradicting_sigmas = 2.5;
  constexpr double unknown_sigma = 10.0;  // [m/s]
  const double ahead = observed.integrated_speed - observed.speed();
  const bool valid = observed.usable(Source::accel_x) && observed.integrated_sigma < unknown_sigma;
  if (valid &&
      (contradicted || std::abs(ahead) > contradicting_sigmas * observed.integrated_sigma)) {
    return;
  }
  const double share = valid ? -std::expm1(-dt / follow_s) : 1.0;
  observed.integrated_speed -= share * ahead;
  observed.integrated_sigma +=
      share * (observed.last_consensus.front().sigma[of::speed] - observed.integrated_sigma);
  if (valid && learns) {
    const double error = ahead / follow_s;
    observed.offset_averaging_s = std::min(observed.offset_averaging_s + dt, slope_s);
    const double gain = dt / observed.offset_averaging_s;
    constexpr double steepest = most_sigmas * largest_slope * gravity;
    observed.accel_offset = std::clamp(observed.accel_offset + gain * error, -steepest, steepest);
    if (std::abs(observed.speed()) < min_learning_speed) {
      return;  // the slope does not change while the car stands
    }
    const double variance = squared(observed.accel_offset_sigma);
    observed.accel_offset_sigma =
        std::clamp(std::sqrt(variance + gain * (error * error - variance)), least_slope * gravity,
                   largest_slope * gravity);
  }
}

}  // namespace odomd::estimator::integrity
