// odom_predict compared with fine numerical integration of the same motion, and what a controller
// checks before it uses a pose.
#include <limits>

#include <odom/odom.hpp>

#include "tests/gtest.hpp"
#include "tests/shm_api/segment_fixture.hpp"

namespace odomd::shm::testing::test_predict {
namespace {

struct Motion {
  double vx, vy, yaw_rate, vx_dot, vy_dot, yaw_accel;
};

odom_pose pose_with(const Motion& m) {
  return {.tick = 42,
          .time_ns = 1'000'000'000,
          .x = 3.0,
          .y = -2.0,
          .yaw = 0.7,
          .odom_x = -5.0,
          .odom_y = 6.0,
          .odom_yaw = -2.1,
          .vx = m.vx,
          .vy = m.vy,
          .yaw_rate = m.yaw_rate,
          .vx_dot = m.vx_dot,
          .vy_dot = m.vy_dot,
          .yaw_accel = m.yaw_accel,
          .covariance = {1e-4, 0.0, 0.0, 1e-4, 0.0, 1e-4},
          .mode = ODOM_TRACKING};
}

struct Point {
  double x, y;
};

// Midpoint rule, 20,000 steps: exact to 1e-11 m here.
Point integrate(const Motion& m, double x, double y, double yaw, double h) {
  const int steps = 20000;
  const double dt = h / steps;
  for (int i = 0; i < steps; ++i) {
    const double t = (i + 0.5) * dt;
    const double heading = yaw + m.yaw_rate * t + 0.5 * m.yaw_accel * t * t;
    const double vx = m.vx + m.vx_dot * t;
    const double vy = m.vy + m.vy_dot * t;
    x += dt * (vx * std::cos(heading) - vy * std::sin(heading));
    y += dt * (vx * std::sin(heading) + vy * std::cos(heading));
  }
  return {x, y};
}

TEST(Predict, AgreesWithFineIntegrationOverTheMotionsOfACar) {
  double worst = 0.0;
  for (const double vx : {-2.0, 0.0, 0.01, 1.5, 5.0})
    for (const double vy : {-0.5, 0.0, 0.3})
      for (const double yaw_rate : {-6.0, -1.0, -1e-9, 0.0, 1e-12, 1e-4, 3.0, 6.0})
        for (const double accel : {-6.0, 0.0, 4.0})
          for (const double yaw_accel : {-30.0, 0.0, 1e-9, 30.0})
            for (const double h : {0.035, 0.1}) {
              const Motion m{vx, vy, yaw_rate, accel, -0.5 * accel, yaw_accel};
              const odom_pose from = pose_with(m);
              odom_pose to{};
              ASSERT_EQ(odom_predict(&from, from.time_ns + std::llround(h * 1e9), &to), ODOM_OK);
              const Point map = integrate(m, from.x, from.y, from.yaw, h);
              const Point odom = integrate(m, from.odom_x, from.odom_y, from.odom_yaw, h);
              worst = std::max(worst, std::hypot(to.x - map.x, to.y - map.y));
              worst = std::max(worst, std::hypot(to.odom_x - odom.x, to.odom_y - odom.y));
              const double turn = yaw_rate * h + 0.5 * yaw_accel * h * h;
              ASSERT_NEAR(to.yaw, from.yaw + turn, 1e-12);
              ASSERT_NEAR(to.odom_yaw, from.odom_yaw + turn, 1e-12);
              ASSERT_NEAR(to.vx, vx + accel * h, 1e-12);
              ASSERT_NEAR(to.yaw_rate, yaw_rate + yaw_accel * h, 1e-12);
            }
  EXPECT_LT(worst, 1e-6);
  std::printf("largest difference: %.3g m\n", worst);
}

TEST(Predict, HorizonIsFromThePoseToAHundredMilliseconds) {
  odom_pose from = pose_with({1.0, 0.0, 0.0, 0.0, 0.0, 0.0});
  odom_pose to{};
  to.tick = 99;
  for (const auto& [time_ns, status] :
       {std::pair<std::int64_t, odom_status>{from.time_ns - 1, ODOM_TOO_OLD},
        {INT64_MIN, ODOM_TOO_OLD},
        {from.time_ns + 100'000'001, ODOM_TOO_NEW},
        {INT64_MAX, ODOM_TOO_NEW}})
    EXPECT_EQ(odom_predict(&from, time_ns, &to), status) << time_ns;
  EXPECT_EQ(to.tick, 99U);
  EXPECT_EQ(odom_predict(&from, from.time_ns + 100'000'000, &to), ODOM_OK);
  EXPECT_NEAR(std::hypot(to.x - from.x, to.y - from.y), 0.1, 1e-12);
  EXPECT_EQ(to.tick, from.tick);
  EXPECT_EQ(odom_predict(nullptr, 0, &to), ODOM_INVALID);
  EXPECT_EQ(odom_predict(&from, 0, nullptr), ODOM_INVALID);
  from.mode = ODOM_INITIALISING;
  EXPECT_EQ(odom_predict(&from, from.time_ns, &to), ODOM_NO_POSE);
}

TEST(Predict, ZeroHorizonChangesNothingAndResultMayAlias) {
  const odom_pose from = pose_with({1.0, 0.2, 3.0, 0.5, 0.0, 1.0});
  odom_pose to{};
  ASSERT_EQ(odom_predict(&from, from.time_ns, &to), ODOM_OK);
  EXPECT_TRUE(is_same(from, to));
  odom_pose same = from;
  ASSERT_EQ(odom_predict(&from, from.time_ns + 35'000'000, &to), ODOM_OK);
  ASSERT_EQ(odom_predict(&same, from.time_ns + 35'000'000, &same), ODOM_OK);
  EXPECT_TRUE(is_same(same, to));
}

TEST(Predict, CovarianceGrowsAndStaysPositiveDefinite) {
  odom_pose p = pose_with({3.0, 0.2, 2.0, -4.0, 0.0, 5.0});
  double last_position = p.covariance[0] + p.covariance[3];
  double last_yaw = p.covariance[5];
  for (int step = 0; step < 20; ++step) {
    ASSERT_EQ(odom_predict(&p, p.time_ns + 5'000'000, &p), ODOM_OK);
    const double* c = p.covariance;
    EXPECT_GT(c[0] + c[3], last_position);
    EXPECT_GT(c[5], last_yaw);
    last_position = c[0] + c[3];
    last_yaw = c[5];
    const double minor = c[0] * c[3] - c[1] * c[1];
    const double det = c[0] * (c[3] * c[5] - c[4] * c[4]) - c[1] * (c[1] * c[5] - c[4] * c[2]) +
                       c[2] * (c[1] * c[4] - c[3] * c[2]);
    EXPECT_GT(minor, 0.0);
    EXPECT_GT(det, 0.0);
  }
}

// The displacement rotates with the initial yaw, whose uncertainty therefore acts across the path.
TEST(Predict, YawUncertaintySwingsThePath) {
  odom_pose from = pose_with({5.0, 0.0, 0.0, 0.0, 0.0, 0.0});
  from.yaw = 0.0;
  for (double& c : from.covariance) c = 0.0;
  from.covariance[5] = 0.04;
  odom_pose to{};
  ASSERT_EQ(odom_predict(&from, from.time_ns + 100'000'000, &to), ODOM_OK);
  EXPECT_NEAR(to.covariance[3] - to.covariance[0], 0.04 * 0.5 * 0.5, 1e-12);
  EXPECT_NEAR(to.covariance[4], 0.04 * 0.5, 1e-12);
}

// Checks of a controller before it uses a pose --------------------------------------------------

odom_pose pose_with_covariance(double xx, double xy, double yy) {
  return {.covariance = {xx, xy, 7.0, yy, 7.0, 9.0}};  // the yaw terms must not matter
}

TEST(PositionSigma, IsTheMajorAxisInAnyDirection) {
  constexpr double major = 0.5;
  constexpr double minor = 0.1;
  for (const double angle : {0.0, 0.1, 0.7, 1.5, 2.5, -1.0}) {
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    const double a = major * major;
    const double b = minor * minor;
    EXPECT_NEAR(odom::position_sigma(pose_with_covariance(a * c * c + b * s * s, (a - b) * c * s,
                                                          a * s * s + b * c * c)),
                major, 1e-15);
  }
  EXPECT_EQ(odom::position_sigma(pose_with_covariance(0.0, 0.0, 0.0)), 0.0);
}

TEST(PositionSigma, IsNanForAnInvalidCovariance) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const odom_pose& pose :
       {pose_with_covariance(nan, 0.0, 1.0), pose_with_covariance(1.0, nan, 1.0),
        pose_with_covariance(-1.0, 0.0, -1.0)})
    EXPECT_TRUE(std::isnan(odom::position_sigma(pose)));
}

TEST(ModeName, IsTheNameInTheStatus) {
  EXPECT_STREQ(odom::mode_name(ODOM_INITIALISING), "initialising");
  EXPECT_STREQ(odom::mode_name(ODOM_DEAD_RECKONING), "dead_reckoning");
  EXPECT_STREQ(odom::mode_name(ODOM_FAULT), "fault");
  EXPECT_STREQ(odom::mode_name(6), "unknown");
  EXPECT_STREQ(odom::mode_name(std::numeric_limits<std::uint32_t>::max()), "unknown");
}

}  // namespace
}  // namespace odomd::shm::testing::test_predict
