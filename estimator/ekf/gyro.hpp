// The gyro: z = (1 + s_g) ψ̇ + b_g.
//
// docs/model.md, "Gyro".
#pragma once

#include "estimator/ekf/update.hpp"

namespace odomd::estimator::full {

[[nodiscard]] inline Prediction predict_yaw_rate(const State& state, double sigma) noexcept {
  const double yaw_rate = state.mean[at::yaw_rate];
  const double scale = 1.0 + state.slow.mean[slow::gyro_scale];
  Prediction z;
  z.value = scale * yaw_rate + state.slow.mean[slow::gyro_bias];
  z.variance = sigma * sigma;
  z.depends_on(at::yaw_rate, scale);
  z.by_slow[slow::gyro_bias] = 1.0;
  z.by_slow[slow::gyro_scale] = yaw_rate;
  return z;
}

}  // namespace odomd::estimator::full
