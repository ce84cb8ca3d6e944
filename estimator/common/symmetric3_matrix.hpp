// Between packed symmetric 3x3 matrices and those of Eigen.
#pragma once

#include <Eigen/Core>

#include "estimator/common/symmetric3.hpp"

namespace odomd::estimator {

[[nodiscard]] inline Symmetric3 packed(const Eigen::Matrix3d& m) noexcept {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2)};
}
[[nodiscard]] inline Eigen::Matrix3d unpacked(const Symmetric3& s) noexcept {
  return Eigen::Matrix3d{{s[0], s[1], s[2]}, {s[1], s[3], s[4]}, {s[2], s[4], s[5]}};
}

}  // namespace odomd::estimator
