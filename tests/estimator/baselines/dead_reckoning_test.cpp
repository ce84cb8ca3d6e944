// The kinematic bicycle and the slip odometer: geometry, forces, and Jacobians against automatic
// differentiation. Their filters are tested in kinematic_filter_test.cpp and
// inertial_filter_test.cpp.
#include "estimator/baselines/motion.hpp"
#include "tests/estimator/autodiff.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::testing::dead_reckoning_test {
namespace {

const Vehicle car;
constexpr std::array kinematic_models{Model::kinematic, Model::kinematic_printed};

DeadReckoning inertial(double v_x, double yaw_rate) {
  return reckon(Model::inertial, car, v_x, yaw_rate);
}

TEST(Kinematic, VelocityAndJacobianAreThoseOfTheModel) {
  // The model again, for automatic differentiation.
  const auto velocity = [](double lever, const Eigen::Matrix<Dual<2>, 2, 1>& input) {
    const Dual<2> yaw_rate = input[0] / car.wheelbase() * tan(input[1]);
    return Eigen::Matrix<Dual<2>, 3, 1>{input[0], lever * yaw_rate, yaw_rate};
  };
  for (const Model model : kinematic_models) {
    const double lever = model == Model::kinematic ? car.rear_axle : 0.0;
    for (const double v_x : {-2.0, 0.0, 0.01, 1.0, 30.0}) {
      for (const double delta : {-0.6, -0.1, 0.0, 0.3, 0.6}) {
        const auto expected = velocity(lever, variables<2, 2>(Eigen::Vector2d{v_x, delta}, 0));
        const DeadReckoning now = reckon(model, car, v_x, delta);
        EXPECT_EQ(now.velocity.v_x, v_x);
        EXPECT_DOUBLE_EQ(now.velocity.v_y, expected[1].value());
        EXPECT_DOUBLE_EQ(now.velocity.yaw_rate, expected[2].value());
        EXPECT_LT((now.jacobian - jacobian<2>(expected)).cwiseAbs().maxCoeff(),
                  1e-12 * (1.0 + std::abs(v_x)))
            << v_x << " " << delta;
      }
    }
  }
}

TEST(Inertial, RearAxleBearsItsShareOfTheSideForceOfASteadyTurn) {
  for (const double v_x : {2.0, -2.0}) {
    for (const double yaw_rate : {0.7, -0.7}) {
      const BodyVelocity v = inertial(v_x, yaw_rate).velocity;
      // If the front wheels roll along their own direction, α_v = 0, only the rear axle turns the
      // car.
      const double delta = (v.v_y + car.front_axle * v.yaw_rate) / v.v_x;
      const double yaw_accel = dynamic_rate(car, v, delta, 0.0, 0.1).yaw_rate;
      const double rear_force = -yaw_accel * car.yaw_inertia / car.rear_axle;
      EXPECT_NEAR(rear_force, car.front_axle / car.wheelbase() * car.mass * v_x * yaw_rate, 1e-12);
    }
  }
}

TEST(Inertial, JacobianIsThatOfTheVelocity) {
  constexpr double step = 1e-6;
  for (const double v_x : {-2.0, 0.4, 3.0}) {
    for (const double yaw_rate : {-1.2, 0.0, 0.9}) {
      const auto j = inertial(v_x, yaw_rate).jacobian;
      const auto v_y = [](double v, double r) { return inertial(v, r).velocity.v_y; };
      EXPECT_NEAR(j(1, 0), (v_y(v_x + step, yaw_rate) - v_y(v_x - step, yaw_rate)) / (2.0 * step),
                  1e-8);
      EXPECT_NEAR(j(1, 1), (v_y(v_x, yaw_rate + step) - v_y(v_x, yaw_rate - step)) / (2.0 * step),
                  1e-8);
      EXPECT_EQ(j(0, 0), 1.0);
      EXPECT_EQ(j(2, 1), 1.0);
    }
  }
}

}  // namespace
}  // namespace odomd::estimator::testing::dead_reckoning_test
