// docs/model.md, "Accelerometers".
#include "estimator/ekf/accelerometer.hpp"

#include <cmath>

#include "estimator/common/vehicle.hpp"

namespace odomd::estimator::full {

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
