#include "tools/identify/stiffness/cornering_stiffness.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tools/identify/stiffness/stiffness.hpp"

namespace odomd::tools::cornering_stiffness_test {
namespace {

using testing::HasSubstr;

// The reference car and what was left unknown of it.
struct Truth {
  double front = 20.0, rear = 60.0;
  double steering_offset = 0.006, steering_scale = 1.015, marker_angle = 0.002;
};

CircleCar car() {
  return {.mass = {2.985, 0.005},
          .front_axle = {0.175, 0.0005},
          .rear_axle = {0.085, 0.0005},
          .rolling_resistance = {0.0, 0.001},
          .sigma_scale = 0.003,
          .sigma_marker = 0.001,
          .marker_distance = 0.3};
}

// A steady circle of a car with linear tyres: v and radius (left positive) give ψ̇, forces, slips,
// drift and steering.
CircleRun circle(const Truth& truth, double speed, double radius) {
  const double yaw_rate = speed / radius, l_v = 0.175, l_h = 0.085, m = 2.985;
  double drift = 0.0, accel = 0.0, steering = 0.0;
  for (int k = 0; k < 50; ++k) {
    accel = speed * std::cos(drift) * yaw_rate;
    const double slip_rear = l_v * m * accel / (0.26 * truth.rear);
    const double v_x = speed * std::cos(drift);
    drift = std::atan2(l_h * yaw_rate - v_x * std::tan(slip_rear), v_x);
    const double slip_front = l_h * m * accel / (0.26 * std::cos(steering) * truth.front);
    steering = slip_front + std::atan2(speed * std::sin(drift) + l_v * yaw_rate, v_x);
  }
  CircleRun run{.film = "film.csv", .speed = speed, .yaw_rate = yaw_rate, .lateral_accel = accel};
  run.drift = {drift + truth.marker_angle, 2e-4};
  run.steering = {truth.steering_scale * steering + truth.steering_offset, 2e-4};
  return run;
}

std::vector<CircleRun> circles(const Truth& truth) {
  std::vector<CircleRun> runs;
  for (const double speed : {0.4, 0.7, 1.0, 1.2})
    for (const double radius : {1.2, -1.2}) runs.push_back(circle(truth, speed, radius));
  return runs;
}

TEST(CorneringStiffness, FindsTheSlopesTogetherWithOffsetsAndScales) {
  const Truth truth;
  const CorneringStiffness found = fit_stiffness(circles(truth), car());
  EXPECT_NEAR(found.front.stiffness.value, truth.front, 0.3);
  EXPECT_NEAR(found.rear.stiffness.value, truth.rear, 0.9);
  EXPECT_LT(2.0 * found.front.stiffness.sigma / truth.front, 0.06);
  EXPECT_LT(2.0 * found.rear.stiffness.sigma / truth.rear, 0.06);
  EXPECT_NEAR(found.steering_offset.value, truth.steering_offset, 1e-3);
  EXPECT_NEAR(found.steering_scale.value, truth.steering_scale, 0.01);
  EXPECT_NEAR(found.marker_angle.value, truth.marker_angle, 5e-4);
}

// The printed small-angle formulas over-read C_v by 4 % at δ = 0.3 (errata 8).
TEST(CorneringStiffness, LargeSteeringAnglesDoNotBiasIt) {
  Truth truth;
  truth.steering_offset = truth.marker_angle = 0.0;
  truth.steering_scale = 1.0;
  std::vector<CircleRun> runs;
  for (const double speed : {0.2, 0.4, 0.6, 0.8})
    for (const double radius : {0.7, -0.7}) runs.push_back(circle(truth, speed, radius));
  EXPECT_GT(runs.back().steering.value, -0.5);
  EXPECT_LT(runs.back().steering.value, -0.35);
  EXPECT_NEAR(fit_stiffness(runs, car()).front.stiffness.value, truth.front, 0.15);
}

TEST(CorneringStiffness, OneCircleThatIsOffDoesNotPullTheRest) {
  const Truth truth;
  std::vector<CircleRun> runs = circles(truth);
  runs[4].drift.value += 0.02;
  const CorneringStiffness found = fit_stiffness(runs, car());
  EXPECT_NEAR(found.rear.stiffness.value, truth.rear, 2.0 * found.rear.stiffness.sigma);
  EXPECT_LT(found.rear.points[4].weight, 0.5);
}

TEST(CorneringStiffness, OneDirectionAloneIsLessPrecise) {
  const Truth truth;
  std::vector<CircleRun> left;
  for (const CircleRun& run : circles(truth))
    if (run.yaw_rate > 0.0) left.push_back(run);
  const CorneringStiffness one = fit_stiffness(left, car());
  const CorneringStiffness both = fit_stiffness(circles(truth), car());
  EXPECT_GT(one.steering_offset.sigma, 3.0 * both.steering_offset.sigma);
  EXPECT_NEAR(one.front.stiffness.value, truth.front, 2.0 * one.front.stiffness.sigma);
}

TEST(CorneringStiffness, LessPreciseInputsGiveLargerUncertainties) {
  const std::vector<CircleRun> runs = circles({});
  CircleCar rough = car();
  rough.mass.sigma = 0.15;
  const double sigma = fit_stiffness(runs, rough).rear.stiffness.sigma;
  EXPECT_GT(sigma / 60.0, 0.05);
  EXPECT_GT(sigma, 2.0 * fit_stiffness(runs, car()).rear.stiffness.sigma);
}

TEST(CorneringStiffness, CrawlingDeterminesNothing) {
  std::vector<CircleRun> runs;
  for (const double radius : {1.2, -1.2}) runs.push_back(circle({}, 0.1, radius));
  const CorneringStiffness found = fit_stiffness(runs, car());
  EXPECT_GT(4.0 * found.rear.stiffness.sigma, found.rear.stiffness.value);
  EXPECT_THROW((void)fit_stiffness({}, car()), std::invalid_argument);
}

TEST(CorneringStiffness, ThePictureShowsBothAxles) {
  const auto drawings = draw_stiffness(fit_stiffness(circles({}), car()));
  ASSERT_EQ(drawings.size(), 2U);
  EXPECT_THAT(drawings[0].svg, HasSubstr("slope at zero slip"));
  EXPECT_THAT(drawings[1].svg, HasSubstr("Rear axle"));
}

}  // namespace
}  // namespace odomd::tools::cornering_stiffness_test
