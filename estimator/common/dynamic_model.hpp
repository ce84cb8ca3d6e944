// The dynamic bicycle: lateral forces of two linear tyres, state x = [v_x, v_y, ψ̇], input
// u = [δ, a_x]. Three forms of it:
//
//   dynamic_rate      continuous (eqs 4-12), with errata 4 and 5
//   paper_step        discrete as printed (eqs 31-33), with errata 1 and 2: what the paper's filter
//                     predicts with. Forward only: see its domain
//   reversible_step   the discrete form that holds through standstill and in reverse (errata, 5)
//
// Stiffnesses are positive (errata, 2); a_x is what an accelerometer at the centre of gravity
// measures. Templates over the scalar, so that the tests can differentiate them automatically.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "estimator/common/vehicle.hpp"

namespace odomd::estimator {

template <typename T>
using DynamicState = Eigen::Matrix<T, 3, 1>;  ///< [v_x, v_y, ψ̇]
template <typename T>
using DynamicInput = Eigen::Matrix<T, 2, 1>;  ///< [δ, a_x]

/// The speed [m/s] at which the lateral motion settles within one `dt`: below it the continuous
/// equations are stiffer than the step resolves. 0.185 m/s for the reference car at 5 ms.
[[nodiscard]] inline double slowest_resolved_speed(const Vehicle& car, double dt) {
  const double c_v = car.cornering_stiffness_front;
  const double c_h = car.cornering_stiffness_rear;
  const double l_v = car.front_axle;
  const double l_h = car.rear_axle;
  return dt *
         std::max((c_v + c_h) / car.mass, (l_v * l_v * c_v + l_h * l_h * c_h) / car.yaw_inertia);
}

/// ẋ = (v̇_x, v̇_y, ψ̈). The slip angles divide by max(|v_x|, speed_floor), speed_floor > 0: above
/// it they are those of the paper, and at standstill they fade to nothing instead of to infinity.
template <typename T>
[[nodiscard]] DynamicState<T> dynamic_rate(const Vehicle& car, const DynamicState<T>& x,
                                           const DynamicInput<T>& u, double speed_floor) {
  using std::abs;
  using std::cos;
  const T& v_x = x[0];
  const T& v_y = x[1];
  const T& yaw_rate = x[2];
  const T& delta = u[0];
  const double m = car.mass;
  const double l_v = car.front_axle;
  const double l_h = car.rear_axle;

  T speed = abs(v_x);
  if (speed < speed_floor) {
    speed = speed_floor;
  }
  // α_v = δ - β - ψ̇ l_v / v, with β = v_y / v: α_v = (v_x δ - (v_y + l_v ψ̇)) / |v_x|
  //                                                (eq. 6, alpha_v_alternative; errata, 5)
  const T alpha_v = (v_x * delta - (v_y + l_v * yaw_rate)) / speed;
  // α_h = -β + ψ̇ l_h / v = -(v_y - l_h ψ̇) / |v_x|         (eq. 7; errata, 5)
  const T alpha_h = -(v_y - l_h * yaw_rate) / speed;
  // F_sv = C_v α_v,  F_sh = C_h α_h                          (eqs 4 and 5, Fsh)
  const T f_sv = car.cornering_stiffness_front * alpha_v;
  const T f_sh = car.cornering_stiffness_rear * alpha_h;
  const T f_sv_lateral = f_sv * cos(delta);
  return {
      // v̇_x = a_x + v_y ψ̇: the accelerometer has felt F_sv sin δ / m already (eq. 10; errata, 4)
      u[1] + v_y * yaw_rate,
      // v̇_y = -v_x ψ̇ + (F_sv cos δ + F_sh) / m              (eq. 11)
      -v_x * yaw_rate + (f_sv_lateral + f_sh) / m,
      // ψ̈ = (l_v F_sv cos δ - l_h F_sh) / J_z                (eq. 12, psidot_dot)
      (l_v * f_sv_lateral - l_h * f_sh) / car.yaw_inertia,
  };
}

namespace detail {

/// The discrete model, with `w` for v_x wherever it stands for inertia: w = v_x as printed,
/// w = |v_x| in the form that can reverse.
template <typename T>
[[nodiscard]] DynamicState<T> discrete_step(const Vehicle& car, const DynamicState<T>& x,
                                            const DynamicInput<T>& u, double dt, const T& w) {
  const T& v_x = x[0];
  const T& v_y = x[1];
  const T& yaw_rate = x[2];
  const T& delta = u[0];
  const double m = car.mass;
  const double j_z = car.yaw_inertia;
  const double l_v = car.front_axle;
  const double l_h = car.rear_axle;
  const double c_v = car.cornering_stiffness_front;
  const double c_h = car.cornering_stiffness_rear;
  const double coupling = dt * (l_v * c_v - l_h * c_h);

  // a = m v_x v_y - Δt (l_v C_v - l_h C_h) ψ̇                 (a; errata, 2)
  const T a = m * w * v_y - coupling * yaw_rate;
  // b = -Δt C_v δ v_x + Δt m v_x² ψ̇                          (b; errata, 1 and 2)
  const T b = -dt * c_v * delta * v_x + dt * m * v_x * w * yaw_rate;
  // c = J_z v_x ψ̇ - Δt (l_v C_v - l_h C_h) v_y               (c; errata, 2)
  const T c = j_z * w * yaw_rate - coupling * v_y;
  // d = -Δt l_v C_v δ v_x                                    (d; errata, 2)
  const T d = -dt * l_v * c_v * delta * v_x;
  return {
      // v_x,k = v_x + Δt a_x                                (eq. 31, discrete_vx)
      v_x + dt * u[1],
      // v_y,k = (a - b) / (m v_x + Δt (C_v + C_h))         (eq. 32, discrete_vy; errata, 2)
      (a - b) / (m * w + dt * (c_v + c_h)),
      // ψ̇_k = (c - d) / (J_z v_x + Δt (l_v² C_v + l_h² C_h))
      //                                                 (eq. 33, discrete_psidot; errata, 2)
      (c - d) / (j_z * w + dt * (l_v * l_v * c_v + l_h * l_h * c_h)),
  };
}

/// The step and its Φ = ∂f/∂x (eq. 15, transition_matrix) at once: they share the quotients.
/// `w_by_v` is dw/dv_x.
struct DiscreteStep {
  Eigen::Vector3d x;
  Eigen::Matrix3d phi;
};

[[nodiscard]] inline DiscreteStep linearised_step(const Vehicle& car, const Eigen::Vector3d& x,
                                                  const Eigen::Vector2d& u, double dt, double w,
                                                  double w_by_v) {
  const double v_x = x[0];
  const double v_y = x[1];
  const double yaw_rate = x[2];
  const double m = car.mass;
  const double j_z = car.yaw_inertia;
  const double l_v = car.front_axle;
  const double l_h = car.rear_axle;
  const double c_v = car.cornering_stiffness_front;
  const double c_h = car.cornering_stiffness_rear;
  const double coupling = dt * (l_v * c_v - l_h * c_h);
  const double steer = dt * c_v * u[0];

  // v_y,k = N_y / D_y and ψ̇_k = N_ψ / D_ψ, as in discrete_step()             (eqs 32 and 33)
  const double per_vy = 1.0 / (m * w + dt * (c_v + c_h));
  const double per_yaw = 1.0 / (j_z * w + dt * (l_v * l_v * c_v + l_h * l_h * c_h));
  const double v_y_next =
      (m * w * v_y - coupling * yaw_rate + steer * v_x - dt * m * v_x * w * yaw_rate) * per_vy;
  const double yaw_rate_next = (j_z * w * yaw_rate - coupling * v_y + l_v * steer * v_x) * per_yaw;

  // ∂(N/D)/∂v_x = (∂N/∂v_x - (N/D) ∂D/∂v_x) / D; by v_y and ψ̇ only N varies.
  const double v_y_by_v_x =
      (m * w_by_v * (v_y - v_y_next) + steer - dt * m * yaw_rate * (w + v_x * w_by_v)) * per_vy;
  const double v_y_by_yaw_rate = -(coupling + dt * m * v_x * w) * per_vy;
  const double yaw_rate_by_v_x =
      (j_z * w_by_v * (yaw_rate - yaw_rate_next) + l_v * steer) * per_yaw;

  DiscreteStep step;
  step.x << v_x + dt * u[1], v_y_next, yaw_rate_next;
  step.phi << 1.0, 0.0, 0.0,                        //
      v_y_by_v_x, m * w * per_vy, v_y_by_yaw_rate,  //
      yaw_rate_by_v_x, -coupling * per_yaw, j_z * w * per_yaw;
  return step;
}

}  // namespace detail

using detail::DiscreteStep;

/// One step as the paper's filter takes it. Domain: its denominators vanish at
/// v_x = -Δt (C_v + C_h) / m and -Δt (l_v² C_v + l_h² C_h) / J_z (-0.134 and -0.185 m/s for the
/// reference car at 5 ms), and the map is unstable below about -0.06 m/s.
template <typename T>
[[nodiscard]] DynamicState<T> paper_step(const Vehicle& car, const DynamicState<T>& x,
                                         const DynamicInput<T>& u, double dt) {
  return detail::discrete_step<T>(car, x, u, dt, x[0]);
}

/// paper_step with its Jacobian at x, the state before the step.
[[nodiscard]] inline DiscreteStep paper_step_linearised(const Vehicle& car,
                                                        const Eigen::Vector3d& x,
                                                        const Eigen::Vector2d& u, double dt) {
  return detail::linearised_step(car, x, u, dt, x[0], 1.0);
}

/// One step in either direction. The denominators never fall below Δt ΣC; at v_x = 0 the map
/// contracts, and its steady state near there is the kinematic one.
template <typename T>
[[nodiscard]] DynamicState<T> reversible_step(const Vehicle& car, const DynamicState<T>& x,
                                              const DynamicInput<T>& u, double dt) {
  using std::abs;
  return detail::discrete_step<T>(car, x, u, dt, abs(x[0]));
}

/// reversible_step with its Jacobian; at v_x = 0, where |v_x| has a kink, the mean of both sides.
[[nodiscard]] inline DiscreteStep reversible_step_linearised(const Vehicle& car,
                                                             const Eigen::Vector3d& x,
                                                             const Eigen::Vector2d& u, double dt) {
  const double sign = (x[0] > 0.0 ? 1.0 : 0.0) - (x[0] < 0.0 ? 1.0 : 0.0);
  return detail::linearised_step(car, x, u, dt, std::abs(x[0]), sign);
}

}  // namespace odomd::estimator
