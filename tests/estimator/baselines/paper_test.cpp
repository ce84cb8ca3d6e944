// The paper's equations: compares the Jacobian of a step with automatic differentiation, and checks
// the steady turn of the errata. paper_filter_test.cpp tests the whole filter.
#include <Eigen/Eigenvalues>

#include "estimator/baselines/motion.hpp"
#include "tests/estimator/autodiff.hpp"
#include "tests/estimator/discrete_step.hpp"
#include "tests/estimator/driving_cases.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::testing::paper_test {
namespace {

constexpr double dt = 0.005;

Eigen::Vector3d vector(const BodyVelocity& v) {
  return {v.v_x, v.v_y, v.yaw_rate};
}

PaperStep step_of(const Vehicle& car, const Eigen::Vector3d& x, const Eigen::Vector2d& u,
                  double step_s = dt) {
  return paper_step(car, {x[0], x[1], x[2]}, u[0], u[1], step_s);
}

Eigen::Vector3d rate_of(const Eigen::Vector3d& x, const Eigen::Vector2d& u, double speed_floor) {
  return vector(dynamic_rate(reference_car, {x[0], x[1], x[2]}, u[0], u[1], speed_floor));
}

void expect_same(const Eigen::Matrix3d& analytic, const Eigen::Matrix3d& automatic,
                 const DrivingCase& at) {
  const double scale = std::max(1.0, automatic.cwiseAbs().maxCoeff());
  EXPECT_LT((analytic - automatic).cwiseAbs().maxCoeff(), 1e-12 * scale)
      << "at x = " << at.x.transpose() << ", u = " << at.u.transpose() << "\nanalytic\n"
      << analytic << "\nautomatic\n"
      << automatic;
}

TEST(PaperStep, JacobianIsThatOfTheStep) {
  for (const DrivingCase& at : grid({-0.04, 0.0, 0.02, 0.3, 2.0, 12.0})) {
    const auto x = variables<3, 3>(at.x, 0);
    const auto step = discrete_step<Dual<3>>(at.car, x, constants<3, 2>(at.u), dt, x[0]);
    const PaperStep analytic = step_of(at.car, at.x, at.u);
    expect_same(analytic.phi, jacobian<3>(step), at);
    EXPECT_LT((vector(analytic.velocity) - values<3>(step)).cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST(PaperStep, IsUnstableInReverseWhereTheErrataSaySo) {
  const auto spectral_radius = [](double v_x) {
    const Eigen::Matrix3d phi = step_of(reference_car, {v_x, 0.0, 0.0}, {0.0, 0.0}).phi;
    const Eigen::Matrix2d lateral = phi.bottomRightCorner<2, 2>();
    return lateral.eigenvalues().cwiseAbs().maxCoeff();
  };
  EXPECT_LT(spectral_radius(-0.05), 1.0);
  EXPECT_GT(spectral_radius(-0.065), 1.0);
}

TEST(DynamicModel, SteadyTurnIsThatOfTheErrata) {
  // 2 m/s, δ = 0.1: v_y = -0.030 m/s, in the discrete form as in the continuous one.
  const Eigen::Vector2d u{0.1, 0.0};
  Eigen::Vector3d x{2.0, 0.0, 0.0};
  for (int i = 0; i < 2000; ++i) {
    x = vector(step_of(reference_car, x, u).velocity);
  }
  EXPECT_NEAR(x[1], -0.030, 0.0005);

  Eigen::Vector3d y{2.0, 0.0, 0.0};
  for (int i = 0; i < 200'000; ++i) {
    Eigen::Vector3d rate = rate_of(y, u, 0.1);
    rate[0] = 0.0;  // v_x is held, as if driven
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
  const Eigen::Vector3d limit = (vector(step_of(reference_car, x, u, tiny).velocity) - x) / tiny;
  const Eigen::Vector3d rate = rate_of(x, u, 0.1);
  EXPECT_NEAR(rate[0], limit[0], 1e-6);
  EXPECT_NEAR(rate[1], limit[1], 1e-3 * std::abs(limit[1]));
  EXPECT_NEAR(rate[2], limit[2], 1e-2 * std::abs(limit[2]));
}

TEST(DynamicModel, AccelerometerIncludesTheTyreDrag) {
  // v̇_x = a_x + v_y ψ̇, whatever the steering does.
  const Eigen::Vector3d rate = rate_of({2.0, 0.1, 1.5}, {0.4, -0.3}, 0.1);
  EXPECT_DOUBLE_EQ(rate[0], -0.3 + 0.1 * 1.5);
}

TEST(DynamicModel, RateIsTheSameCarInMirrorAndBounded) {
  for (const double v_x : {-1.0, -0.1, 0.0, 0.1, 2.0}) {
    const Eigen::Vector3d left = rate_of({v_x, 0.1, 0.5}, {0.3, 0.2}, 0.185);
    const Eigen::Vector3d right = rate_of({v_x, -0.1, -0.5}, {-0.3, 0.2}, 0.185);
    EXPECT_DOUBLE_EQ(left[0], right[0]);
    EXPECT_DOUBLE_EQ(left[1], -right[1]);
    EXPECT_DOUBLE_EQ(left[2], -right[2]);
    EXPECT_LT(left.cwiseAbs().maxCoeff(), 100.0);
  }
}

TEST(DynamicModel, StandingCarAtFullLockDoesNotAccelerate) {
  const Eigen::Vector3d rate = rate_of({0.0, 0.0, 0.0}, {0.45, 0.0}, 0.185);
  EXPECT_EQ(rate, Eigen::Vector3d::Zero());
}

TEST(DynamicModel, SlowestResolvedSpeedIsThePoleOfThePrintedForm) {
  EXPECT_NEAR(slowest_resolved_speed(reference_car, dt), 0.185, 0.0005);
}

}  // namespace
}  // namespace odomd::estimator::testing::paper_test
