#include "tools/evaluation/time_offset.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "tests/tools/drives.hpp"

namespace odomd::tools::time_offset_test {
namespace {

Trajectory late_by(double seconds, Trajectory trajectory) {
  for (auto& point : trajectory.points)
    point.t_ns += static_cast<std::int64_t>(std::llround(seconds * 1e9));
  return trajectory;
}

const Trajectory truth = wavy_drive(0.0, 20.0, 0.01);

/// As camera poses keep it: within a centimetre, without a drift.
Trajectory held() {
  Trajectory estimate = wavy_drive(0.5, 19.5, 0.005);
  for (auto& point : estimate.points) {
    const double phase = static_cast<double>(point.t_ns) * 1e-7;
    point.pose.x += 0.01 * std::sin(phase);
    point.pose.y += 0.01 * std::cos(1.7 * phase);
    point.pose.yaw += 0.01 * std::sin(2.3 * phase);
  }
  return estimate;
}

/// As dead reckoning makes it: the gyro over-reads and has a bias, the wheels are too small.
Trajectory drifting() {
  Trajectory estimate = wavy_drive(0.5, 19.5, 0.005);
  estimator::Pose2 before = estimate.points.front().pose;
  estimator::Pose2 pose = before;
  for (auto& point : estimate.points) {
    estimator::Pose2 moved = relative(before, point.pose);
    before = point.pose;
    moved.x *= 1.05;
    moved.yaw = 1.005 * moved.yaw + 0.005 * 0.005;
    pose = compose(pose, moved);
    point.pose = pose;
  }
  return estimate;
}

TEST(TimeOffset, IsFoundOfAnEstimateThatStaysWithTheReference) {
  for (const double late : {-0.15, -0.05, 0.03, 0.1}) {
    const auto found = offset_by_positions(late_by(late, truth), held(), Align::none);
    ASSERT_TRUE(found) << late;
    EXPECT_NEAR(found->late_s, late, 0.005);
    EXPECT_NEAR(found->before, std::fabs(late), 0.015);  // at 1 m/s
    EXPECT_LT(found->after, 0.015);
  }
  EXPECT_FALSE(offset_by_positions(truth, held(), Align::none));
  EXPECT_FALSE(offset_by_positions(late_by(0.01, truth), held(), Align::none));
}

TEST(TimeOffset, IsFoundOfAnEstimateThatDrifts) {
  for (const double late : {-0.15, -0.1, 0.1, 0.15}) {
    const auto found = offset_by_motion(late_by(late, truth), drifting());
    ASSERT_TRUE(found) << late;
    EXPECT_NEAR(found->late_s, late, 0.01);
  }
  EXPECT_FALSE(offset_by_motion(truth, drifting()));
}

TEST(TimeOffset, IsNoWrongWheelLeverArmOrHeading) {
  Trajectory large_wheels = wavy_drive(0.0, 20.0, 0.01);
  for (auto& point : large_wheels.points) {  // straight on: ahead by more and more
    point.pose = {1.03 * static_cast<double>(point.t_ns) * 1e-9, 0.0, 0.0};
  }
  Trajectory straight = large_wheels;
  for (auto& point : straight.points) point.pose.x /= 1.03;
  const auto has_offset = [](const Trajectory& reference, const Trajectory& estimate) {
    return offset_by_positions(reference, estimate, Align::none) ||
           offset_by_motion(reference, estimate);
  };
  EXPECT_FALSE(has_offset(straight, large_wheels));
  EXPECT_FALSE(has_offset(at_centre_of_gravity(truth, {0.1, 0.0, 0.0}), held()));
  EXPECT_FALSE(has_offset(at_centre_of_gravity(truth, {0.0, 0.0, 0.1}), held()));
}

TEST(TimeOffset, IsNoSteeringThatIsAheadOfTheCar) {
  // Turns 0.1 s before the car does, and by a fifth more, as tyres that slip let a kinematic model.
  Trajectory estimate = wavy_drive(0.5, 19.5, 0.005);
  double x = estimate.points.front().pose.x;
  double y = estimate.points.front().pose.y;
  const double begin = estimate.points.front().pose.yaw;
  for (auto& point : estimate.points) {
    const auto ahead = at(truth, point.t_ns + 100'000'000);
    point.pose = {x, y, begin + 1.2 * (ahead->pose.yaw - begin)};
    x += 0.005 * std::cos(point.pose.yaw);
    y += 0.005 * std::sin(point.pose.yaw);
  }
  EXPECT_FALSE(offset_by_positions(truth, estimate, Align::first));
  EXPECT_FALSE(offset_by_motion(truth, estimate));
}

TEST(TimeOffset, SaysNothingOfACarThatStandsOrOfLittle) {
  Trajectory standing = truth;
  for (auto& point : standing.points) point.pose = {1.0, 2.0, 0.5};
  EXPECT_FALSE(offset_by_positions(standing, standing, Align::none));
  EXPECT_FALSE(offset_by_motion(standing, standing));
  const Trajectory little = wavy_drive(5.0, 5.2, 0.005);
  EXPECT_FALSE(offset_by_positions(late_by(0.1, truth), little, Align::none));
  EXPECT_FALSE(offset_by_motion(late_by(0.1, truth), little));
  EXPECT_FALSE(offset_by_motion(little, late_by(0.1, truth)));
}

}  // namespace
}  // namespace odomd::tools::time_offset_test
