// The motion of the full filter against automatic differentiation, and against the models it is
// made of.
#include "estimator/ekf/model.hpp"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "estimator/common/dynamic_model.hpp"
#include "tests/estimator/autodiff.hpp"

namespace odomd::estimator::full::model_test {
namespace {

using estimator::testing::constants;
using estimator::testing::Dual;
using estimator::testing::jacobian;
using estimator::testing::variables;

constexpr double dt = 0.005;

/// States from standstill to fast, forward and in reverse, straight and at full lock.
std::vector<std::pair<Vector, Input>> grid() {
  std::vector<std::pair<Vector, Input>> points;
  for (const double v_x : {-3.0, -0.4, -0.02, 0.003, 0.1, 1.0, 4.0, 20.0}) {
    for (const double v_y : {-0.3, 0.0, 0.2}) {
      for (const double yaw_rate : {-2.0, 0.0, 1.5}) {
        for (const double steering : {-0.45, 0.0, 0.45}) {
          Vector x;
          x << 3.0, -2.0, 0.7, v_x, v_y, yaw_rate, 0.6, 0.4, 0.1, 0.01, -0.08, 0.02, 0.01, -0.2,
              0.015;
          points.push_back({x, {steering, 0.8, true, true}});
          points.push_back({x, {steering, 0.8, false, false}});
        }
      }
    }
  }
  return points;
}

CarModel car_with_imu_ahead() {
  CarModel model;
  model.imu_position = {0.04, 0.015};
  return model;
}

TEST(FullModel, VelocityJacobianIsThatOfAutomaticDifferentiation) {
  const CarModel model = car_with_imu_ahead();
  for (const auto& [x, input] : grid()) {
    const Eigen::Matrix<double, 8, 1> s = x.segment<8>(at::v_x);
    const auto dual = next_velocity<Dual<8>>(model, input, variables<8, 8>(s, 0), dt);
    const VelocityStep step = velocity_linearised(model, input, x, dt);
    const double scale = 1.0 + jacobian<8, 3>(dual).cwiseAbs().maxCoeff();
    EXPECT_LT((step.velocity - estimator::testing::values<8, 3>(dual)).norm(), 1e-12);
    EXPECT_LT((step.by - (jacobian<8, 3>(dual))).cwiseAbs().maxCoeff(), 1e-11 * scale)
        << x.transpose();
  }
}

TEST(FullModel, StepJacobianIsThatOfAutomaticDifferentiation) {
  const CarModel model = car_with_imu_ahead();
  using D = Dual<10>;  // pose but for its yaw is carried over: x, then yaw ... stiffness_scale
  for (const auto& [x, input] : grid()) {
    const Eigen::Matrix<double, 8, 1> s = x.segment<8>(at::v_x);
    const Eigen::Matrix<D, 8, 1> states = variables<10, 8>(s, 2);
    Eigen::Matrix<D, 3, 1> pose = constants<10, 3>(Eigen::Vector3d(x.head<3>()));
    pose[0] = D(x[at::x], 10, 0);
    pose[2] = D(x[at::yaw], 10, 1);
    const Eigen::Matrix<D, 3, 1> after = next_velocity<D>(model, input, states, dt);
    const Eigen::Matrix<D, 3, 1> before = states.head<3>();
    const Eigen::Matrix<D, 3, 1> moved = next_pose<D>(pose, before, after, dt);

    const Step step = step_linearised(model, input, x, dt);
    Eigen::Matrix<double, 6, 10> expected;
    expected << jacobian<10, 3>(moved), jacobian<10, 3>(after);
    const Eigen::Matrix<double, 6, 15> F =
        times_transposed(Matrix::Identity(), step).leftCols<6>().transpose();
    EXPECT_LT((F.middleCols<9>(at::yaw) - expected.rightCols<9>()).cwiseAbs().maxCoeff(),
              1e-11 * (1.0 + expected.cwiseAbs().maxCoeff()));
    EXPECT_EQ(expected(0, 0), 1.0);
    EXPECT_EQ((F.topLeftCorner<2, 2>()), Eigen::Matrix2d::Identity());
    EXPECT_TRUE((F.bottomLeftCorner<4, 2>().isZero(0.0)));
    EXPECT_TRUE(F.rightCols<4>().isZero(0.0));
    EXPECT_LT((step.mean.head<3>() - (estimator::testing::values<10, 3>(moved))).norm(), 1e-12);
    EXPECT_LT((step.mean.segment<3>(at::v_x) - (estimator::testing::values<10, 3>(after))).norm(),
              1e-12);
  }
}

TEST(FullModel, WithoutCorrectionsItIsTheReversibleStep) {
  const CarModel model;
  for (const double v_x : {-2.0, -0.1, 0.0, 0.5, 3.0}) {
    Vector x = Vector::Zero();
    x.segment<3>(at::v_x) << v_x, 0.1, 0.8;
    const Input input{0.2, 0.5, true, true};
    const Eigen::Vector3d expected =
        reversible_step<double>(model.car, x.segment<3>(at::v_x), {0.2, 0.5}, dt);
    const VelocityStep step = velocity_linearised(model, input, x, dt);
    // The discrete form as printed drops v_y ψ̇ (errata, 4).
    EXPECT_NEAR(step.velocity[0], expected[0] + dt * 0.1 * 0.8, 1e-15);
    EXPECT_NEAR(step.velocity[1], expected[1], 1e-15);
    EXPECT_NEAR(step.velocity[2], expected[2], 1e-15);
  }
}

TEST(FullModel, CovarianceIsThatOfTheWholeJacobian) {
  const CarModel model = car_with_imu_ahead();
  const Matrix root = Matrix::Random();
  const Matrix product = root * root.transpose() * 1e-2 + Matrix::Identity() * 1e-3;
  const Matrix P = 0.5 * (product + product.transpose());
  for (const auto& [x, input] : grid()) {
    const Step step = step_linearised(model, input, x, dt);
    Matrix F = Matrix::Identity();
    F.topRows<8>() = times_transposed(Matrix::Identity(), step).transpose();
    EXPECT_EQ(F.row(at::front_force), step.decay * Matrix::Identity().row(at::front_force));
    EXPECT_EQ(F.row(at::yaw_moment), step.moment_decay * Matrix::Identity().row(at::yaw_moment));
    Vector mean = x;
    Matrix propagated = P;
    propagate(model, input, dt, mean, propagated);
    Matrix added = propagated - F * P * F.transpose();
    const Matrix noise = added.diagonal().asDiagonal();
    EXPECT_LT((added - noise).cwiseAbs().maxCoeff(), 1e-12 * (1.0 + F.norm()));
    EXPECT_GE(added.diagonal().minCoeff(), -1e-12);
    EXPECT_EQ(propagated, propagated.transpose());
    EXPECT_EQ(mean, step.mean);
  }
}

TEST(FullModel, NoiseIsADensity) {
  // Ten steps of a millisecond leave what one of ten leaves, but for the curvature of the way.
  const CarModel model;
  const Input input{0.1, 0.0, true, true};
  Vector coarse = Vector::Zero();
  coarse[at::v_x] = 2.0;
  Vector fine = coarse;
  Matrix P_coarse = Matrix::Identity() * 1e-4;
  Matrix P_fine = P_coarse;
  propagate(model, input, 0.002, coarse, P_coarse);
  for (int i = 0; i < 10; ++i) {
    propagate(model, input, 0.0002, fine, P_fine);
  }
  for (Eigen::Index i = 0; i < at::size; ++i) {
    EXPECT_NEAR(P_fine(i, i), P_coarse(i, i), 0.08 * P_coarse(i, i)) << i;
  }
}

}  // namespace
}  // namespace odomd::estimator::full::model_test
