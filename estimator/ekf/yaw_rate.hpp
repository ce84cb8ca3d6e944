// The gyro: z = (1 + s_g) ψ̇ + b_g.
#pragma once

#include "estimator/ekf/prediction.hpp"

namespace odomd::estimator::full {

[[nodiscard]] inline Prediction predict_yaw_rate(const State& state, double sigma) noexcept {
  const double yaw_rate = state.mean[at::yaw_rate];
  const double scale = 1.0 + state.mean[at::gyro_scale];
  Prediction z;
  z.value = scale * yaw_rate + state.mean[at::gyro_bias];
  z.variance = sigma * sigma;
  z.depends_on(at::yaw_rate, scale);
  z.depends_on(at::gyro_bias, 1.0);
  z.depends_on(at::gyro_scale, yaw_rate);
  return z;
}

}  // namespace odomd::estimator::full
