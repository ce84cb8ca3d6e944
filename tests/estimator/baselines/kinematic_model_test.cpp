// The kinematic bicycle: geometry, and Jacobians against automatic differentiation.
#include "estimator/baselines/kinematic_model.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/estimator/autodiff.hpp"

namespace odomd::estimator::kinematic_model_test {
namespace {

using testing::Dual;
using testing::jacobian;
using testing::variables;

constexpr std::array forms{KinematicForm::centre_of_gravity, KinematicForm::printed};
const Vehicle car;

TEST(KinematicModel, YawRateIsThatOfTheCircleThroughBothAxles) {
  for (const KinematicForm form : forms) {
    const Eigen::Vector3d v = kinematic_velocity<double>(car, form, {1.0, 0.3});
    EXPECT_DOUBLE_EQ(v[0], 1.0);
    EXPECT_DOUBLE_EQ(v[2], std::tan(0.3) / 0.26);
  }
}

TEST(KinematicModel, RearAxleDoesNotSlip) {
  const Eigen::Vector3d v =
      kinematic_velocity<double>(car, KinematicForm::centre_of_gravity, {1.3, -0.4});
  EXPECT_DOUBLE_EQ(v[1] - car.rear_axle * v[2], 0.0);
}

TEST(KinematicModel, FrontWheelDoesNotSlip) {
  const double delta = 0.35;
  const Eigen::Vector3d v =
      kinematic_velocity<double>(car, KinematicForm::centre_of_gravity, {1.3, delta});
  const double lateral = v[1] + car.front_axle * v[2];
  EXPECT_NEAR(std::atan2(lateral, v[0]), delta, 1e-15);
}

TEST(KinematicModel, AsPrintedTheCentreOfGravityDoesNotSlip) {
  EXPECT_EQ(kinematic_velocity<double>(car, KinematicForm::printed, {1.0, 0.3})[1], 0.0);
}

TEST(KinematicModel, ReversingTurnsTheOtherWay) {
  const auto form = KinematicForm::centre_of_gravity;
  EXPECT_EQ(kinematic_velocity<double>(car, form, {-0.7, 0.4}),
            -kinematic_velocity<double>(car, form, {0.7, 0.4}));
}

TEST(KinematicModel, VelocityJacobianIsThatOfTheModel) {
  for (const KinematicForm form : forms) {
    for (const double v_x : {-2.0, 0.0, 0.01, 1.0, 30.0}) {
      for (const double delta : {-0.6, -0.1, 0.0, 0.3, 0.6}) {
        const Eigen::Vector2d input{v_x, delta};
        const auto v = kinematic_velocity<Dual<2>>(car, form, variables<2, 2>(input, 0));
        const Eigen::Matrix<double, 3, 2> analytic = kinematic_velocity_jacobian(car, form, input);
        EXPECT_LT((analytic - jacobian<2>(v)).cwiseAbs().maxCoeff(), 1e-12 * (1.0 + std::abs(v_x)))
            << v_x << " " << delta;
      }
    }
  }
}

TEST(KinematicModel, PoseRateJacobiansAreThoseOfTheModel) {
  for (const KinematicForm form : forms) {
    for (const double v_x : {-2.0, 0.0, 1.0, 30.0}) {
      for (const double delta : {-0.6, 0.0, 0.3}) {
        for (const double yaw : {-7.0, -1.0, 0.0, 2.5}) {
          const Eigen::Vector3d pose{1.0, -2.0, yaw};
          const Eigen::Vector2d input{v_x, delta};
          const KinematicJacobians analytic = kinematic_pose_rate_jacobians(car, form, pose, input);
          const auto rate = kinematic_pose_rate<Dual<5>>(car, form, variables<5, 3>(pose, 0),
                                                         variables<5, 2>(input, 3));
          const Eigen::Matrix<double, 3, 5> automatic = jacobian<5>(rate);
          const double limit = 1e-12 * (1.0 + 10.0 * std::abs(v_x));
          EXPECT_LT((analytic.pose - automatic.leftCols<3>()).cwiseAbs().maxCoeff(), limit);
          EXPECT_LT((analytic.input - automatic.rightCols<2>()).cwiseAbs().maxCoeff(), limit);
        }
      }
    }
  }
}

}  // namespace
}  // namespace odomd::estimator::kinematic_model_test
