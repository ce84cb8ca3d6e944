// The paper's extended Kalman filter, bare: one predict and one correct of x = [v_x, v_y, ψ̇] with
// u = [δ, a_x] and z = [ψ̇, v_x]. No time, no signals, no pose: those are around it.
//
// P is kept packed, so it is symmetric by construction. With H picking ψ̇ and v_x out of the state,
// S is 2x2 and is inverted in closed form.
#pragma once

#include <Eigen/Core>

#include "estimator/common/dynamic_model.hpp"
#include "estimator/common/settings.hpp"
#include "estimator/common/symmetric3.hpp"
#include "estimator/common/vehicle.hpp"

namespace odomd::estimator {

struct PaperEkf {
  Vehicle car;
  PaperNoise noise;
  double dt = 0.005;

  Eigen::Vector3d x = Eigen::Vector3d::Zero();  ///< [v_x, v_y, ψ̇]
  Symmetric3 P = diagonal(1.0, 1.0, 1.0);
};

/// u = [δ, a_x]
inline void predict(PaperEkf& ekf, const Eigen::Vector2d& u) noexcept {
  const Symmetric3 P = ekf.P;
  // x̂⁻ = f(x̂⁺, u),  Φ = ∂f/∂x at x̂⁺          (eqs 17, state_prediction, and 15)
  const DiscreteStep step = paper_step_linearised(ekf.car, ekf.x, u, ekf.dt);
  ekf.x = step.x;
  // P⁻ = Φ P Φᵀ + Q                             (eq. 18, covariance_prediction)
  // The first row of Φ is (1 0 0); r and s are P times the second and third row.
  const double f0 = step.phi(1, 0);
  const double f1 = step.phi(1, 1);
  const double f2 = step.phi(1, 2);
  const double g0 = step.phi(2, 0);
  const double g1 = step.phi(2, 1);
  const double g2 = step.phi(2, 2);
  const double r0 = f0 * P[0] + f1 * P[1] + f2 * P[2];
  const double r1 = f0 * P[1] + f1 * P[3] + f2 * P[4];
  const double r2 = f0 * P[2] + f1 * P[4] + f2 * P[5];
  const double s0 = g0 * P[0] + g1 * P[1] + g2 * P[2];
  const double s1 = g0 * P[1] + g1 * P[3] + g2 * P[4];
  const double s2 = g0 * P[2] + g1 * P[4] + g2 * P[5];
  ekf.P[0] = P[0] + ekf.noise.Q[0];
  ekf.P[1] = r0;
  ekf.P[2] = s0;
  ekf.P[3] = f0 * r0 + f1 * r1 + f2 * r2 + ekf.noise.Q[1];
  ekf.P[4] = g0 * r0 + g1 * r1 + g2 * r2;
  ekf.P[5] = g0 * s0 + g1 * s1 + g2 * s2 + ekf.noise.Q[2];
}

/// z = [ψ̇, v_x]
inline void correct(PaperEkf& ekf, const Eigen::Vector2d& z) noexcept {
  const Symmetric3 P = ekf.P;
  // S = H P⁻ Hᵀ + R with H = [0 0 1; 1 0 0]
  const double s00 = P[5] + ekf.noise.R[0];
  const double s01 = P[2];
  const double s11 = P[0] + ekf.noise.R[1];
  const double per_det = 1.0 / (s00 * s11 - s01 * s01);
  const double i00 = s11 * per_det;
  const double i01 = -s01 * per_det;
  const double i11 = s00 * per_det;
  // K = P⁻ Hᵀ S⁻¹                               (eq. 19, kalman_gain)
  // P⁻ Hᵀ is the third and the first column of P⁻.
  const double k00 = P[2] * i00 + P[0] * i01;
  const double k01 = P[2] * i01 + P[0] * i11;
  const double k10 = P[4] * i00 + P[1] * i01;
  const double k11 = P[4] * i01 + P[1] * i11;
  const double k20 = P[5] * i00 + P[2] * i01;
  const double k21 = P[5] * i01 + P[2] * i11;
  // x̂⁺ = x̂⁻ + K (z - h(x̂⁻))                    (eq. 20, state_update)
  const double nu0 = z[0] - ekf.x[2];
  const double nu1 = z[1] - ekf.x[0];
  ekf.x[0] += k00 * nu0 + k01 * nu1;
  ekf.x[1] += k10 * nu0 + k11 * nu1;
  ekf.x[2] += k20 * nu0 + k21 * nu1;
  // P⁺ = (I - K H) P⁻                           (eq. 21, covariance_update)
  ekf.P[0] = P[0] - k00 * P[2] - k01 * P[0];
  ekf.P[1] = P[1] - k00 * P[4] - k01 * P[1];
  ekf.P[2] = P[2] - k00 * P[5] - k01 * P[2];
  ekf.P[3] = P[3] - k10 * P[4] - k11 * P[1];
  ekf.P[4] = P[4] - k10 * P[5] - k11 * P[2];
  ekf.P[5] = P[5] - k20 * P[5] - k21 * P[2];
}

}  // namespace odomd::estimator
