// docs/model.md, "Measurements".
#include "estimator/ekf/measurement_models.hpp"

#include <algorithm>
#include <cmath>

#include "estimator/common/symmetric3.hpp"
#include "estimator/common/time.hpp"
#include "estimator/common/vehicle.hpp"
#include "estimator/ekf/plausibility.hpp"

namespace odomd::estimator::full {

namespace {

// Without a steering signal: largest angle of the front wheels, and slowest speed [m/s] at which
// their direction is defined.
constexpr double largest_steering = 0.6;
constexpr double slowest_steered = 0.3;

/// δ: the measured one, or the direction of the front axle's velocity, atan((v_y + l_v ψ̇) / v_x).
double steering_of(const Vehicle& car, const Input& input, const Vector& x) noexcept {
  if (input.has_steering) {
    return input.steering - x[at::steering_offset];
  }
  const double v_x = x[at::v_x];
  if (std::abs(v_x) < slowest_steered) {
    return 0.0;
  }
  const double goes = std::atan((x[at::v_y] + car.front_axle * x[at::yaw_rate]) / v_x);
  return std::clamp(goes, -largest_steering, largest_steering);
}

}  // namespace

Prediction predict_yaw_rate(const State& state, double sigma, double advanced_s) noexcept {
  // ψ̈ from the gyro's own mean rate of change.
  const double yaw_accel =
      state.standstill.standing
          ? 0.0
          : state.integrity.history(Source::yaw_rate).rate(integrity::Over::short_time);
  const double yaw_rate =
      state.mean[at::yaw_rate] - (state.slow.mean[slow::gyro_latency] - advanced_s) * yaw_accel;
  const double scale = 1.0 + state.slow.mean[slow::gyro_scale];
  Prediction z;
  z.value = scale * yaw_rate + state.slow.mean[slow::gyro_bias];
  z.variance = sigma * sigma;
  z.depends_on(at::yaw_rate, scale);
  z.by_slow[slow::gyro_bias] = 1.0;
  z.by_slow[slow::gyro_scale] = yaw_rate;
  z.by_slow[slow::gyro_latency] = -scale * yaw_accel;
  return z;
}

Prediction predict_wheel_speed(const CarModel& model, const Input& input, const State& state,
                               Source source, double sigma, bool gyro, double advanced_s) noexcept {
  const WheelPlace place = wheel_place(model.car, source);
  const Tuning& tuning = model.tuning;
  const Vector& x = state.mean;
  const double yaw_rate = x[at::yaw_rate];
  const double steering = steering_of(model.car, input, x);
  const double delta = place.steered ? steering : 0.0;
  const double c = std::cos(delta);
  const double s = std::sin(delta);
  // v̇_x = a_x + v_y ψ̇ (errata, 4); the sample shows the speed τ_w - advanced_s earlier.
  const double v_x_dot = x[at::accel_x] + x[at::v_y] * yaw_rate;
  const double v_x = x[at::v_x] - (state.slow.mean[slow::wheel_latency] - advanced_s) * v_x_dot;
  const double along = v_x - place.left * yaw_rate;
  const double across = x[at::v_y] + place.ahead * yaw_rate;
  const double rolling = along * c + across * s;
  // Driving force / m: acceleration, and drag of the front tyres in a turn,
  // F_sv sin δ / m = (l_h / l) v ψ̇ sin δ.
  const double forward = x[at::v_x] < 0.0 ? -1.0 : 1.0;
  const double drag =
      model.car.rear_axle / model.car.wheelbase() * x[at::v_x] * yaw_rate * std::sin(steering);
  const double force = forward * (x[at::accel_x] + drag);
  const double share = slip_share(model.car.driven, source, force);
  const double slip = 1.0 + state.slow.mean[slow::wheel_slip] * share * force;
  const double side = place.left == 0.0 ? 0.0 : std::copysign(0.5, place.left);
  const double scale_alone = 1.0 + state.slow.mean[slow::wheel_scale];
  const double unlike = 1.0 + side * state.slow.mean[slow::wheel_difference];
  const double radius = scale_alone * unlike;
  const double scale = radius * slip;
  const double by_yaw_rate = -place.left * c + place.ahead * s;
  const double by_delta = place.steered ? across * c - along * s : 0.0;

  Prediction z;
  z.value = scale * rolling;
  // The wheel with the smallest noise scale keeps its weight: wheels may be inconsistent with each
  // other, but an accelerometer must not outweigh them all.
  const double noise_scale = state.reading(source).noise_scale;
  double least = noise_scale;
  bool free = share == 0.0;
  for (const Source wheel : wheel_sources) {
    if (is_current(state, wheel, state.time_ns)) {
      least = std::min(least, state.reading(wheel).noise_scale);
      free = free || slip_share(model.car.driven, wheel, force) == 0.0;
    }
  }
  z.relative = noise_scale * squared(tuning.wheel_radius * rolling);
  // A driven tyre that slides sideways also spins.
  const double sideways = across * c - along * s;
  const double spinning =
      is_driven(model.car.driven, source) && knows_speed(model.car.driven, state)
          ? tuning.spin * slide_of(sideways, along, model.car)
          : 0.0;
  const double slipping = squared(tuning.slip_noise * share * force * rolling);
  z.slack = z.relative * (1.0 - 1.0 / std::max(least, 1.0)) + (free ? 0.0 : slipping);
  z.slip = squared(state.integrity.slip_sigma(source));
  z.variance = squared(sigma) + z.slip + z.relative + slipping + squared(spinning) +
               squared(by_delta * tuning.front_wheel) + squared(s) * state.variance(at::v_y);
  z.depends_on(at::v_x, scale * c);
  z.by_slow[slow::wheel_latency] = -scale * c * v_x_dot;
  z.by_slow[slow::wheel_scale] = unlike * slip * rolling;
  z.by_slow[slow::wheel_difference] = side * scale_alone * slip * rolling;
  z.by_slow[slow::wheel_slip] = radius * share * force * rolling;
  if (share > 0.0) {
    z.depends_on(at::accel_x,
                 radius * forward * state.slow.mean[slow::wheel_slip] * share * rolling);
  }
  if (gyro) {
    z.variance += squared(by_yaw_rate) * state.variance(at::yaw_rate);
  } else {
    z.depends_on(at::yaw_rate, scale * by_yaw_rate);
  }
  return z;
}

Prediction predict_accel_x(const CarModel& model, const State& state, double sigma) noexcept {
  const double yaw_rate = state.mean[at::yaw_rate];
  const double scale = 1.0 + state.slow.mean[slow::pitch_gradient];
  const double force = state.mean[at::accel_x] - yaw_rate * yaw_rate * model.imu_position[0];
  Prediction z;
  z.value = state.mean[at::accel_bias_x];
  z.variance = sigma * sigma;
  z.depends_on(at::accel_bias_x, 1.0);
  if (state.standstill.standing) {
    return z;
  }
  z.value += scale * force;
  z.depends_on(at::accel_x, scale);
  z.by_slow[slow::pitch_gradient] = force;
  return z;
}

Prediction predict_accel_y(const CarModel& model, const Input& input, const State& state,
                           double sigma, double dt) noexcept {
  const Vector& x = state.mean;
  const double v_x = x[at::v_x];
  const double yaw_rate = x[at::yaw_rate];
  Prediction z;
  z.value = x[at::accel_bias_y];
  z.variance = sigma * sigma;
  z.depends_on(at::accel_bias_y, 1.0);
  if (state.standstill.standing) {
    return z;
  }
  const double scale = 1.0 + state.slow.mean[slow::roll_gradient];
  if (std::abs(v_x) < slowest_resolved_speed(model.car, dt)) {
    z.value += scale * v_x * yaw_rate;
    z.variance += v_x * v_x * yaw_rate * yaw_rate;
    z.by_slow[slow::roll_gradient] = v_x * yaw_rate;
    return z;
  }
  const VelocityStep step = velocity_step(model.car, moving(state, input), dt);
  const double per_dt = 1.0 / dt;
  const double ahead = model.imu_position[0];
  const double left = model.imu_position[1];
  const double side = (step.velocity[1] - x[at::v_y]) * per_dt + v_x * yaw_rate;
  const double yaw_accel = (step.velocity[2] - yaw_rate) * per_dt;
  const double force = side + yaw_accel * ahead - yaw_rate * yaw_rate * left;
  z.value += scale * force;
  const double unknown = model.tuning.accel_scale * force;
  z.variance += unknown * unknown;
  z.by_slow[slow::roll_gradient] = force;
  z.by_slow[slow::stiffness_scale] =
      scale * per_dt * (step.by_stiffness[0] + ahead * step.by_stiffness[1]);
  z.by_slow[slow::softness] = scale * per_dt * (step.by_softness[0] + ahead * step.by_softness[1]);

  const Eigen::RowVector3d by = scale * per_dt * (step.by.row(1) + ahead * step.by.row(2));
  const double by_front =
      scale * per_dt * (step.by_front_wheel[0] + ahead * step.by_front_wheel[1]);
  z.depends_on(at::v_x, by[0] + scale * yaw_rate);
  z.depends_on(at::v_y, by[1] - scale * per_dt);
  z.depends_on(at::yaw_rate, by[2] + scale * (v_x - per_dt * ahead - 2.0 * yaw_rate * left));
  z.depends_on(at::side_force, scale * per_dt * step.by_side_force);
  z.depends_on(at::front_angle, by_front);
  if (input.has_steering) {
    z.depends_on(at::steering_offset, -by_front);
  }
  return z;
}

}  // namespace odomd::estimator::full
