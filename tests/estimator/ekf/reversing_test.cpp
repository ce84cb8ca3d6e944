// The full filter's velocity step where the printed one is invalid: through standstill, and in
// reverse (errata, 5).
#include <Eigen/Eigenvalues>

#include "estimator/baselines/motion.hpp"
#include "estimator/ekf/process_model.hpp"
#include "tests/estimator/driving_cases.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::full::reversing_test {
namespace {

using estimator::testing::DrivingCase;
using estimator::testing::grid;
using estimator::testing::reference_car;

constexpr double dt = 0.005;

/// A step of a car that is driven with v̇_x = `accel`, whatever v_y ψ̇ is.
VelocityStep step_of(const Vehicle& car, const Eigen::Vector3d& x, double steering, double accel) {
  return velocity_step(car,
                       {.v_x = x[0],
                        .v_y = x[1],
                        .yaw_rate = x[2],
                        .accel_x = accel - x[1] * x[2],
                        .front_wheel = steering,
                        .stiffness = 1.0,
                        .softness = -1.0},
                       dt);
}

Eigen::Vector3d after(const Vehicle& car, const Eigen::Vector3d& x, double steering, double accel) {
  return step_of(car, x, steering, accel).velocity;
}

TEST(Reversing, LateralJacobianAtStandstillIsTheMeanOfBothSides) {
  constexpr double h = 1e-7;
  for (const DrivingCase& at : grid({0.0})) {
    Eigen::Matrix3d numeric;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d e = h * Eigen::Vector3d::Unit(i);
      numeric.col(i) =
          (after(at.car, at.x + e, at.u[0], 1.3) - after(at.car, at.x - e, at.u[0], 1.3)) /
          (2.0 * h);
    }
    const Eigen::Matrix3d analytic = step_of(at.car, at.x, at.u[0], 1.3).by;
    const double scale = std::max(1.0, numeric.cwiseAbs().maxCoeff());
    EXPECT_LT((analytic - numeric).bottomRows<2>().cwiseAbs().maxCoeff(), 1e-5 * scale);
  }
}

TEST(Reversing, StepMatchesThePaperWhenDrivingForward) {
  for (const DrivingCase& at : grid({0.0, 0.02, 0.3, 2.0, 12.0})) {
    const BodyVelocity paper =
        paper_step(at.car, {at.x[0], at.x[1], at.x[2]}, at.u[0], 1.3, dt).velocity;
    const Eigen::Vector3d step = after(at.car, at.x, at.u[0], 1.3);
    EXPECT_NEAR(step[0], paper.v_x, 1e-14 * (1.0 + std::abs(paper.v_x)));
    EXPECT_NEAR(step[1], paper.v_y, 1e-14 * (1.0 + std::abs(paper.v_y)));
    EXPECT_NEAR(step[2], paper.yaw_rate, 1e-14 * (1.0 + std::abs(paper.yaw_rate)));
  }
}

TEST(Reversing, HoldsThroughStandstillAtFullLock) {
  // From 2 m/s forward to 2 m/s in reverse and back at full lock, past the poles of the printed
  // form (-0.134 and -0.185 m/s).
  for (const double lock : {-0.45, 0.45}) {
    Eigen::Vector3d x{2.0, 0.0, 0.0};
    for (int i = 0; i < 3200; ++i) {
      const double accel = i < 1600 ? -0.5 : 0.5;
      x = after(reference_car, x, lock, accel);
      ASSERT_TRUE(x.allFinite());
      // The bound is the kinematic yaw rate at full lock, with a margin for transients.
      const double bound = 1.2 * std::abs(x[0]) * std::tan(0.45) / reference_car.wheelbase() + 0.1;
      ASSERT_LT(std::abs(x[2]), bound) << "v_x = " << x[0];
      ASSERT_LT(std::abs(x[1]), 1.0) << "v_x = " << x[0];
    }
    EXPECT_NEAR(x[0], 2.0, 1e-9);
    EXPECT_GT(x[2] * lock, 0.0);
  }
}

TEST(Reversing, SettlesOnTheKinematicTurnAtWalkingPaceInBothDirections) {
  for (const double v_x : {-0.05, -0.01, 0.01, 0.05}) {
    Eigen::Vector3d x{v_x, 0.0, 0.0};
    for (int i = 0; i < 2000; ++i) x = after(reference_car, x, 0.3, 0.0);
    // The discrete model steers by δ, and the geometry by tan δ.
    const BodyVelocity turn = reckon(Model::kinematic, reference_car, v_x, std::atan(0.3)).velocity;
    EXPECT_NEAR(x[2] / turn.yaw_rate, 1.0, 0.01) << "v_x = " << v_x;
    EXPECT_NEAR(x[1] / turn.v_y, 1.0, 0.01) << "v_x = " << v_x;
  }
}

TEST(Reversing, IsAsStableAsTheCarItself) {
  const auto spectral_radius = [](double v_x) {
    const Eigen::Matrix2d lateral =
        step_of(reference_car, {v_x, 0.0, 0.0}, 0.0, 0.0).by.bottomRightCorner<2, 2>();
    return lateral.eigenvalues().cwiseAbs().maxCoeff();
  };
  EXPECT_LT(spectral_radius(-0.065), 1.0);  // the printed form is unstable here
  EXPECT_LT(spectral_radius(-4.0), 1.0);
  EXPECT_GT(spectral_radius(-4.2), 1.0);  // a car driven fast in reverse spins round
}

}  // namespace
}  // namespace odomd::estimator::full::reversing_test
