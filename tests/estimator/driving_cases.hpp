// Cars and motions for tests of the bicycle's steps.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "estimator/common/vehicle.hpp"

namespace odomd::estimator::testing {

inline const Vehicle reference_car;
inline const Vehicle full_size_car{1500.0, 1.2, 1.5, 2500.0, 90e3, 110e3, 1.55};

/// x = [v_x, v_y, ψ̇], u = [δ, a_x].
struct DrivingCase {
  Vehicle car;
  Eigen::Vector3d x;
  Eigen::Vector2d u;
};

/// Cases of both cars from straight ahead to beyond full lock, sliding and spinning.
inline std::vector<DrivingCase> grid(const std::vector<double>& speeds) {
  std::vector<DrivingCase> cases;
  for (const Vehicle& car : {reference_car, full_size_car}) {
    for (const double v_x : speeds) {
      for (const double v_y : {-0.5, 0.0, 0.2}) {
        for (const double yaw_rate : {-3.0, 0.0, 1.0})
          for (const double steering : {-0.6, -0.1, 0.0, 0.35, 0.6})
            cases.push_back({car, {v_x, v_y, yaw_rate}, {steering, 1.3}});
      }
    }
  }
  return cases;
}

}  // namespace odomd::estimator::testing
