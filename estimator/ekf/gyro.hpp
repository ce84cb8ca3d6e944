// The gyro: z = (1 + s_g) (ψ̇ - τ ψ̈) + b_g, τ: what is left of τ_g after the sample was advanced.
//
// docs/model.md, "Gyro".
#pragma once

#include "estimator/ekf/update.hpp"

namespace odomd::estimator::full {

[[nodiscard]] inline Prediction predict_yaw_rate(const State& state, double sigma,
                                                 double advanced_s = 0.0) noexcept {
  // ψ̈ by the gyro's own mean rate of change.
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

}  // namespace odomd::estimator::full
