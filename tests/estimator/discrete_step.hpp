// An independent implementation of the discrete dynamic bicycle (eqs 31-33 with errata 1 and 2), to
// check the filters' steps and Jacobians.
#pragma once

#include <Eigen/Core>

#include "estimator/common/vehicle.hpp"

namespace odomd::estimator::testing {

/// x = [v_x, v_y, ψ̇], u = [δ, a_x]; `w` replaces v_x in the inertia terms: v_x as printed, |v_x|
/// in the form that can reverse (errata, 5).
template <typename T>
[[nodiscard]] Eigen::Matrix<T, 3, 1> discrete_step(const Vehicle& car,
                                                   const Eigen::Matrix<T, 3, 1>& x,
                                                   const Eigen::Matrix<T, 2, 1>& u, double dt,
                                                   const T& w) {
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
  const T a = m * w * v_y - coupling * yaw_rate;
  const T b = -dt * c_v * delta * v_x + dt * m * v_x * w * yaw_rate;
  const T c = j_z * w * yaw_rate - coupling * v_y;
  const T d = -dt * l_v * c_v * delta * v_x;
  return {
      v_x + dt * u[1],
      (a - b) / (m * w + dt * (c_v + c_h)),
      (c - d) / (j_z * w + dt * (l_v * l_v * c_v + l_h * l_h * c_h)),
  };
}

}  // namespace odomd::estimator::testing
