// The dynamic bicycle: Jacobians against automatic differentiation, the steady turn of the errata,
// and that the reversible form holds where the printed one does not.
#include "estimator/common/dynamic_model.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>
#include <vector>

#include "estimator/baselines/kinematic_model.hpp"
#include "tests/estimator/autodiff.hpp"

namespace odomd::estimator::dynamic_model_test {
namespace {

using testing::constants;
using testing::Dual;
using testing::jacobian;
using testing::values;
using testing::variables;

constexpr double dt = 0.005;
const Vehicle reference_car;
const Vehicle full_size_car{1500.0, 1.2, 1.5, 2500.0, 90e3, 110e3, 1.55};

struct Case {
  Vehicle car;
  Eigen::Vector3d x;
  Eigen::Vector2d u;
};

/// Slow to fast, straight to beyond full lock, sliding and spinning.
std::vector<Case> grid(const std::vector<double>& speeds) {
  std::vector<Case> cases;
  for (const Vehicle& car : {reference_car, full_size_car}) {
    for (const double v_x : speeds) {
      for (const double v_y : {-0.5, 0.0, 0.2}) {
        for (const double yaw_rate : {-3.0, 0.0, 1.0}) {
          for (const double steering : {-0.6, -0.1, 0.0, 0.35, 0.6}) {
            cases.push_back({car, {v_x, v_y, yaw_rate}, {steering, 1.3}});
          }
        }
      }
    }
  }
  return cases;
}

void expect_same(const Eigen::Matrix3d& analytic, const Eigen::Matrix3d& automatic,
                 const Case& at) {
  const double scale = std::max(1.0, automatic.cwiseAbs().maxCoeff());
  EXPECT_LT((analytic - automatic).cwiseAbs().maxCoeff(), 1e-12 * scale)
      << "at x = " << at.x.transpose() << ", u = " << at.u.transpose() << "\nanalytic\n"
      << analytic << "\nautomatic\n"
      << automatic;
}

TEST(PaperStep, JacobianIsThatOfTheStep) {
  for (const Case& at : grid({-0.04, 0.0, 0.02, 0.3, 2.0, 12.0})) {
    const auto step =
        paper_step<Dual<3>>(at.car, variables<3, 3>(at.x, 0), constants<3, 2>(at.u), dt);
    const DiscreteStep analytic = paper_step_linearised(at.car, at.x, at.u, dt);
    expect_same(analytic.phi, jacobian<3>(step), at);
    EXPECT_LT((analytic.x - values<3>(step)).cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST(ReversibleStep, JacobianIsThatOfTheStep) {
  for (const Case& at : grid({-12.0, -2.0, -0.18, -0.134, -0.02, 0.02, 0.3, 2.0, 12.0})) {
    const auto step =
        reversible_step<Dual<3>>(at.car, variables<3, 3>(at.x, 0), constants<3, 2>(at.u), dt);
    const DiscreteStep analytic = reversible_step_linearised(at.car, at.x, at.u, dt);
    expect_same(analytic.phi, jacobian<3>(step), at);
    EXPECT_LT((analytic.x - values<3>(step)).cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST(ReversibleStep, JacobianAtStandstillIsTheMeanOfBothSides) {
  constexpr double h = 1e-7;
  for (const Case& at : grid({0.0})) {
    Eigen::Matrix3d numeric;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d e = h * Eigen::Vector3d::Unit(i);
      numeric.col(i) = (reversible_step<double>(at.car, at.x + e, at.u, dt) -
                        reversible_step<double>(at.car, at.x - e, at.u, dt)) /
                       (2.0 * h);
    }
    const Eigen::Matrix3d analytic = reversible_step_linearised(at.car, at.x, at.u, dt).phi;
    const double scale = std::max(1.0, numeric.cwiseAbs().maxCoeff());
    EXPECT_LT((analytic - numeric).cwiseAbs().maxCoeff(), 1e-5 * scale);
  }
}

TEST(ReversibleStep, IsThePapersStepWhenDrivingForward) {
  for (const Case& at : grid({0.0, 0.02, 0.3, 2.0, 12.0})) {
    EXPECT_EQ(reversible_step<double>(at.car, at.x, at.u, dt),
              paper_step<double>(at.car, at.x, at.u, dt));
  }
}

TEST(ReversibleStep, HoldsThroughStandstillAtFullLock) {
  // From 2 m/s forward to 2 m/s in reverse and back at full lock, past the poles of the printed
  // form (-0.134 and -0.185 m/s).
  for (const double lock : {-0.45, 0.45}) {
    Eigen::Vector3d x{2.0, 0.0, 0.0};
    for (int i = 0; i < 3200; ++i) {
      const double accel = i < 1600 ? -0.5 : 0.5;
      x = reversible_step<double>(reference_car, x, {lock, accel}, dt);
      ASSERT_TRUE(x.allFinite());
      // The tightest circle of the wheelbase bounds the yaw rate; the transients stay near it.
      const double bound = 1.2 * std::abs(x[0]) * std::tan(0.45) / reference_car.wheelbase() + 0.1;
      ASSERT_LT(std::abs(x[2]), bound) << "v_x = " << x[0];
      ASSERT_LT(std::abs(x[1]), 1.0) << "v_x = " << x[0];
    }
    EXPECT_NEAR(x[0], 2.0, 1e-9);
    EXPECT_GT(x[2] * lock, 0.0);
  }
}

TEST(ReversibleStep, ContractsAtStandstill) {
  Eigen::Vector3d x{0.0, 0.3, -2.0};
  for (int i = 0; i < 20; ++i) {
    x = reversible_step<double>(reference_car, x, {0.4, 0.0}, dt);
  }
  EXPECT_LT(x.cwiseAbs().maxCoeff(), 1e-6);
}

TEST(ReversibleStep, SettlesOnTheKinematicTurnAtWalkingPaceInBothDirections) {
  for (const double v_x : {-0.05, -0.01, 0.01, 0.05}) {
    const Eigen::Vector2d u{0.3, 0.0};
    Eigen::Vector3d x{v_x, 0.0, 0.0};
    for (int i = 0; i < 2000; ++i) {
      x = reversible_step<double>(reference_car, x, u, dt);
    }
    // The discrete model steers by δ where the geometry has tan δ.
    const Eigen::Vector3d kinematic = kinematic_velocity<double>(
        reference_car, KinematicForm::centre_of_gravity, {v_x, std::atan(0.3)});
    EXPECT_NEAR(x[2] / kinematic[2], 1.0, 0.01) << "v_x = " << v_x;
    EXPECT_NEAR(x[1] / kinematic[1], 1.0, 0.01) << "v_x = " << v_x;
  }
}

TEST(PaperStep, IsUnstableInReverseWhereTheErrataSaySo) {
  const auto spectral_radius = [](double v_x, bool reversible) {
    const Eigen::Vector3d x{v_x, 0.0, 0.0};
    const Eigen::Matrix3d phi =
        reversible ? reversible_step_linearised(reference_car, x, {0.0, 0.0}, dt).phi
                   : paper_step_linearised(reference_car, x, {0.0, 0.0}, dt).phi;
    const Eigen::Matrix2d lateral = phi.bottomRightCorner<2, 2>();
    return lateral.eigenvalues().cwiseAbs().maxCoeff();
  };
  EXPECT_LT(spectral_radius(-0.05, false), 1.0);
  EXPECT_GT(spectral_radius(-0.065, false), 1.0);
  EXPECT_LT(spectral_radius(-0.065, true), 1.0);
  EXPECT_LT(spectral_radius(-4.0, true), 1.0);
  EXPECT_GT(spectral_radius(-4.2, true), 1.0);  // the car itself: driven fast in reverse it turns
}

TEST(DynamicModel, SteadyTurnIsThatOfTheErrata) {
  // 2 m/s, δ = 0.1: v_y = -0.030 m/s, in the discrete form as in the continuous one.
  const Eigen::Vector2d u{0.1, 0.0};
  Eigen::Vector3d x{2.0, 0.0, 0.0};
  for (int i = 0; i < 2000; ++i) {
    x = paper_step<double>(reference_car, x, u, dt);
  }
  EXPECT_NEAR(x[1], -0.030, 0.0005);

  Eigen::Vector3d y{2.0, 0.0, 0.0};
  for (int i = 0; i < 200'000; ++i) {
    Eigen::Vector3d rate = dynamic_rate<double>(reference_car, y, u, 0.1);
    rate[0] = 0.0;  // v_x held, as if driven
    y += 5e-5 * rate;
  }
  EXPECT_NEAR(y[1], -0.030, 0.0005);
  EXPECT_NEAR(y[2], x[2], 0.01 * x[2]);
}

TEST(DynamicModel, RateIsTheLimitOfTheDiscreteStep) {
  // The discrete form takes cos δ for 1 and drops v_y ψ̇, so compare at a small δ and v_y.
  const Eigen::Vector3d x{1.5, 0.0, 0.6};
  const Eigen::Vector2d u{0.02, 0.7};
  constexpr double tiny = 1e-7;
  const Eigen::Vector3d limit = (paper_step<double>(reference_car, x, u, tiny) - x) / tiny;
  const Eigen::Vector3d rate = dynamic_rate<double>(reference_car, x, u, 0.1);
  EXPECT_NEAR(rate[0], limit[0], 1e-6);
  EXPECT_NEAR(rate[1], limit[1], 1e-3 * std::abs(limit[1]));
  EXPECT_NEAR(rate[2], limit[2], 1e-2 * std::abs(limit[2]));
}

TEST(DynamicModel, AccelerometerHasFeltTheTyreDragAlready) {
  // v̇_x = a_x + v_y ψ̇, whatever the steering does.
  const Eigen::Vector3d rate =
      dynamic_rate<double>(reference_car, {2.0, 0.1, 1.5}, {0.4, -0.3}, 0.1);
  EXPECT_DOUBLE_EQ(rate[0], -0.3 + 0.1 * 1.5);
}

TEST(DynamicModel, RateIsTheSameCarInMirrorAndBounded) {
  for (const double v_x : {-1.0, -0.1, 0.0, 0.1, 2.0}) {
    const Eigen::Vector3d left =
        dynamic_rate<double>(reference_car, {v_x, 0.1, 0.5}, {0.3, 0.2}, 0.185);
    const Eigen::Vector3d right =
        dynamic_rate<double>(reference_car, {v_x, -0.1, -0.5}, {-0.3, 0.2}, 0.185);
    EXPECT_DOUBLE_EQ(left[0], right[0]);
    EXPECT_DOUBLE_EQ(left[1], -right[1]);
    EXPECT_DOUBLE_EQ(left[2], -right[2]);
    EXPECT_LT(left.cwiseAbs().maxCoeff(), 100.0);
  }
}

TEST(DynamicModel, StandingCarAtFullLockDoesNotAccelerate) {
  const Eigen::Vector3d rate =
      dynamic_rate<double>(reference_car, {0.0, 0.0, 0.0}, {0.45, 0.0}, 0.185);
  EXPECT_EQ(rate, Eigen::Vector3d::Zero());
}

TEST(DynamicModel, SlowestResolvedSpeedIsThePoleOfThePrintedForm) {
  EXPECT_NEAR(slowest_resolved_speed(reference_car, dt), 0.185, 0.0005);
}

}  // namespace
}  // namespace odomd::estimator::dynamic_model_test
