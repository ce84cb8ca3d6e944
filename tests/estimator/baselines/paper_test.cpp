// The paper's equations and its filter: compares the Jacobian of a step with automatic
// differentiation and the whole filter with the author's filter, and checks the steady turn of the
// errata and when the filter stops.
#include "estimator/baselines/motion.hpp"

#include <Eigen/Eigenvalues>

#include "estimator/filter.hpp"
#include "tests/estimator/autodiff.hpp"
#include "tests/estimator/drive.hpp"
#include "tests/estimator/driving_cases.hpp"
#include "tests/estimator/golden.hpp"

namespace odomd::estimator::testing::paper_test {
namespace {

/// An independent implementation of the discrete dynamic bicycle (eqs 31-33 with errata 1 and 2).
/// x = [v_x, v_y, ψ̇], u = [δ, a_x].
template <typename T>
Eigen::Matrix<T, 3, 1> discrete_step(const Vehicle& car, const Eigen::Matrix<T, 3, 1>& x,
                                     const Eigen::Matrix<T, 2, 1>& u, double dt) {
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
  const T a = m * v_x * v_y - coupling * yaw_rate;
  const T b = -dt * c_v * delta * v_x + dt * m * v_x * v_x * yaw_rate;
  const T c = j_z * v_x * yaw_rate - coupling * v_y;
  const T d = -dt * l_v * c_v * delta * v_x;
  return {
      v_x + dt * u[1],
      (a - b) / (m * v_x + dt * (c_v + c_h)),
      (c - d) / (j_z * v_x + dt * (l_v * l_v * c_v + l_h * l_h * c_h)),
  };
}

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

TEST(PaperStep, JacobianMatchesAutomaticDifferentiation) {
  for (const DrivingCase& at : grid({-0.04, 0.0, 0.02, 0.3, 2.0, 12.0})) {
    const auto x = variables<3, 3>(at.x, 0);
    const Eigen::Matrix<Dual<3>, 2, 1> u = at.u.cast<Dual<3>>();
    const auto step = discrete_step<Dual<3>>(at.car, x, u, dt);
    const PaperStep analytic = step_of(at.car, at.x, at.u);
    const Eigen::Matrix3d automatic = jacobian<3>(step);
    EXPECT_LT((analytic.phi - automatic).cwiseAbs().maxCoeff(),
              1e-12 * std::max(1.0, automatic.cwiseAbs().maxCoeff()))
        << "at x = " << at.x.transpose() << ", u = " << at.u.transpose();
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

TEST(DynamicModel, SteadyTurnMatchesTheErrata) {
  // 2 m/s, δ = 0.1: v_y = -0.030 m/s, in the discrete form as in the continuous one.
  const Eigen::Vector2d u{0.1, 0.0};
  Eigen::Vector3d x{2.0, 0.0, 0.0};
  for (int i = 0; i < 2000; ++i) x = vector(step_of(reference_car, x, u).velocity);
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
  // The discrete form assumes cos δ = 1 and omits v_y ψ̇, so compare at a small δ and v_y.
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

TEST(DynamicModel, RateIsMirrorSymmetricAndBounded) {
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
  EXPECT_TRUE(rate_of({0.0, 0.0, 0.0}, {0.45, 0.0}, 0.185).isZero(0.0));
}

TEST(DynamicModel, SlowestResolvedSpeedIsThePoleOfThePrintedForm) {
  EXPECT_NEAR(slowest_resolved_speed(reference_car, dt), 0.185, 0.0005);
}

// The filter
// ---------------------------------------------------------------------------------------

constexpr double tolerance = 1e-9;

TEST(PaperFilter, AgreesWithTheAuthorsFilterFromAnyPose) {
  const Pose2 initial{3.0, -4.0, 1.2};
  Drive drive = start(Model::paper);
  Drive elsewhere = start(Model::paper, {}, initial);
  std::size_t step = 0;
  for (const auto& [steering, accel_x, yaw_rate, speed, expected] : read_golden()) {
    const Samples samples{speed, steering, yaw_rate, accel_x};
    const Estimate e = drive.tick(samples);
    ASSERT_TRUE(e.initialised);
    const std::array<double, 6> in_map{e.v_x, e.v_y, e.yaw_rate, e.map.x, e.map.y, e.map.yaw};
    for (std::size_t i = 0; i < in_map.size(); ++i)
      ASSERT_NEAR(in_map[i], expected[i], tolerance) << "column " << i << ", step " << step;
    ASSERT_EQ(numbers_of(e.map), numbers_of(e.odom));
    const Pose2 moved = compose(initial, {expected[3], expected[4], expected[5]});
    ASSERT_THAT(elsewhere.tick(samples).map, PoseNear(moved, 10.0 * tolerance)) << step;
    ++step;
  }
  EXPECT_EQ(step, 4000U);
}

TEST(PaperFilter, IgnoresTheTimesOfItsSamples) {
  Drive fresh = start(Model::paper);
  Drive late = start(Model::paper);
  for (int i = 0; i < 1000; ++i) {
    const double speed = 1.0 + 0.001 * i;
    fresh.tick({.speed = speed, .steering = 0.1, .yaw_rate = 0.4});
    for (const auto& [source, value] :
         {std::pair(Source::wheel_rear, speed), {Source::steering, 0.1}, {Source::yaw_rate, 0.4}})
      add(late.filter, Measurement{source, late.now_ns - 300 * millisecond, value, 0.0});
    late.tick();
    ASSERT_EQ(fresh.last.map.x, late.last.map.x);
  }
}

TEST(PaperFilter, UsesTheAccelerationButNotTheLateralOne) {
  Drive drive = start(Model::paper);
  EXPECT_EQ(drive.send(Source::accel_x, 1.0), Verdict::fused);
  EXPECT_EQ(drive.send(Source::accel_y, 2.0), Verdict::source_off);
  EXPECT_EQ(drive.send(Source::accel_y, 2.0), Verdict::duplicate);
  const Estimate e = drive.tick({.speed = 1.0});
  EXPECT_EQ(e.accel_x, 1.0);
  EXPECT_EQ(e.accel_y, 2.0);
}

TEST(PaperFilter, DerivativesMatchTheContinuousModel) {
  Drive drive = start(Model::paper);
  const Estimate e =
      drive.ticks(300, {.speed = 1.5, .steering = 0.15, .yaw_rate = 0.8, .accel_x = 0.4});
  const BodyVelocity rate = dynamic_rate(Vehicle{}, {e.v_x, e.v_y, e.yaw_rate}, 0.15, 0.4, 0.185);
  EXPECT_DOUBLE_EQ(e.v_x_dot, rate.v_x);
  EXPECT_DOUBLE_EQ(e.v_y_dot, rate.v_y);
  EXPECT_DOUBLE_EQ(e.yaw_accel, rate.yaw_rate);
}

TEST(PaperFilter, StopsForGoodWhenItReverses) {
  Drive drive = start(Model::paper);
  drive.ticks(200, {.speed = 0.5, .steering = 0.3, .yaw_rate = 0.6});
  Estimate before;
  for (int i = 0; i < 400 && !drive.last.model_fault; ++i) {
    before = drive.last;
    ASSERT_GE(before.v_x, -0.05);
    drive.tick({.speed = -0.5, .steering = 0.3, .yaw_rate = -0.6});
  }
  ASSERT_TRUE(drive.last.model_fault);
  EXPECT_EQ(drive.last.mode, Mode::fault);
  const auto expect_frozen = [&](const Estimate& e) {
    EXPECT_EQ(numbers_of(e.map), numbers_of(before.map));
    EXPECT_THAT((std::array{e.v_x, e.v_y, e.yaw_rate, e.v_y_dot}), ::testing::Each(0.0));
    EXPECT_EQ(e.mode, Mode::fault);
    EXPECT_TRUE(is_positive_definite(e.covariance));
  };
  expect_frozen(drive.last);
  // Neither driving forward again nor a camera clears the fault.
  drive.ticks(1000, {.speed = 1.0, .steering = 0.0, .yaw_rate = 0.0});
  EXPECT_EQ(drive.see({1.0, 1.0, 1.0}, 9.0, 9.0), Verdict::source_off);
  expect_frozen(drive.tick({.speed = 1.0}));
}

TEST(PaperFilter, RollingBackwardsSlowlyIsNotAFault) {
  Drive drive = start(Model::paper);
  drive.ticks(4000, {.speed = -0.03, .steering = 0.3, .yaw_rate = -0.03});
  EXPECT_FALSE(drive.last.model_fault);
  EXPECT_LT(drive.last.map.x, -0.5);
}

TEST(PaperFilter, NonFiniteStateIsNeverEmitted) {
  // Inputs within the physical limits, but Q and R that overflow the covariance.
  FilterSettings settings;
  settings.paper.Q = {1e308, 1e308, 1e308};
  settings.paper.R = {1e308, 1e308};
  Drive drive = start(Model::paper, settings);
  for (int i = 0; i < 100; ++i) {
    const Estimate e = drive.tick({.speed = 1.0, .steering = 0.3, .yaw_rate = 1.0});
    ASSERT_TRUE(is_finite(e.map));
    ASSERT_TRUE(is_finite(e.covariance));
    ASSERT_TRUE(is_finite(e.velocity_covariance));
    ASSERT_TRUE(is_finite(BodyVelocity{e.v_x, e.v_y, e.yaw_rate}));
  }
  EXPECT_GT(drive.last.recoveries, 0U);
}

}  // namespace
}  // namespace odomd::estimator::testing::paper_test
