#include "estimator/ekf/accel_y.hpp"

#include <cmath>

#include "estimator/common/dynamic_model.hpp"

namespace odomd::estimator::full {
namespace {

// What a side acceleration at walking pace may be that nothing here models [m/s²].
constexpr double unmodelled = 1.0;
// By how much the sensor's scale may be off.
constexpr double scale_error = 0.02;

}  // namespace

Prediction predict_accel_y(const CarModel& model, const Input& input, const State& state,
                           double sigma, double dt) noexcept {
  const Vector& x = state.mean;
  const double v_x = x[at::v_x];
  const double yaw_rate = x[at::yaw_rate];
  Prediction z;
  z.variance = sigma * sigma;
  z.depends_on(at::accel_bias_y, 1.0);
  if (state.rest.standing) {
    z.value = x[at::accel_bias_y];
    return z;
  }
  if (std::abs(v_x) < slowest_resolved_speed(model.car, dt)) {
    z.value = x[at::accel_bias_y] + v_x * yaw_rate;
    z.variance += unmodelled * unmodelled;
    return z;
  }
  const VelocityStep step = velocity_linearised(model, input, x, dt);
  const double per_dt = 1.0 / dt;
  const double ahead = model.imu_position[0];
  const double left = model.imu_position[1];
  const double side = (step.velocity[1] - x[at::v_y]) * per_dt + v_x * yaw_rate;
  const double yaw_accel = (step.velocity[2] - yaw_rate) * per_dt;
  z.value = side + yaw_accel * ahead - yaw_rate * yaw_rate * left + x[at::accel_bias_y];
  z.variance += scale_error * scale_error * side * side;

  Eigen::Matrix<double, 1, 8> by = per_dt * (step.by.row(1) + ahead * step.by.row(2));
  by[0] += yaw_rate;
  by[1] -= per_dt;
  by[2] += v_x - per_dt * ahead - 2.0 * yaw_rate * left;
  for (const at::Index state_index : {at::v_x, at::v_y, at::yaw_rate, at::front_force,
                                      at::yaw_moment, at::steering_offset, at::stiffness_scale}) {
    z.depends_on(state_index, by[state_index - at::v_x]);
  }
  return z;
}

}  // namespace odomd::estimator::full
