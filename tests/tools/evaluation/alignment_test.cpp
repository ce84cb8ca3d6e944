// Comparison of poses with a reference: alignment, lever arm and time offset.
#include "tests/gtest.hpp"
#include "tests/tools/drives.hpp"
#include "tools/evaluation/pose_error.hpp"
#include "tools/evaluation/time_offset.hpp"
#include "tools/math/se2.hpp"

namespace odomd::tools::alignment_test {
namespace {

void expect_near(const estimator::Pose2& a, const estimator::Pose2& b, double tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.yaw, b.yaw, tolerance);
}

TEST(Alignment, FirstAndFitBothUndoARigidMotion) {
  const Trajectory reference = wavy_drive(0.0, 10.0, 0.01);
  const estimator::Pose2 away{5.0, -2.0, 2.5};
  const Trajectory estimate = moved_by(inverse(away), reference);
  const auto pairs = common_times(reference, estimate);
  expect_near(alignment(pairs, Align::first), away, 1e-12);
  expect_near(alignment(pairs, Align::fit), away, 1e-12);
  expect_near(alignment(pairs, Align::none), {}, 0.0);
}

TEST(Alignment, FitIsBetterThanAnyNeighbour) {
  const Trajectory reference = wavy_drive(0.0, 10.0, 0.01);
  Trajectory estimate = reference;
  for (std::size_t i = 0; i < estimate.points.size(); ++i) {
    estimate.points[i].pose.x += 0.1 * std::sin(0.01 * static_cast<double>(i));
  }
  const auto pairs = common_times(reference, estimate);
  const auto cost = [&](const estimator::Pose2& T) {
    double sum = 0.0;
    for (const Pair& pair : pairs) {
      const auto p = compose(T, pair.estimate.pose);
      sum += std::pow(p.x - pair.reference.pose.x, 2) + std::pow(p.y - pair.reference.pose.y, 2);
    }
    return sum;
  };
  const auto best = alignment(pairs, Align::fit);
  for (const double step : {-1e-3, 1e-3}) {
    EXPECT_LT(cost(best), cost({best.x + step, best.y, best.yaw}));
    EXPECT_LT(cost(best), cost({best.x, best.y + step, best.yaw}));
    EXPECT_LT(cost(best), cost({best.x, best.y, best.yaw + step}));
  }
}

TEST(Alignment, FitOfACarThatStandsTakesTheRotationFromTheHeadings) {
  Trajectory reference = wavy_drive(0.0, 1.0, 0.01);
  for (auto& point : reference.points) point.pose = {2.0, 1.0, 0.7};
  Trajectory estimate = reference;
  for (auto& point : estimate.points) point.pose = {0.0, 0.0, 0.2};
  expect_near(alignment(common_times(reference, estimate), Align::fit), {2.0, 1.0, 0.5}, 1e-12);
}

TEST(LeverArm, IsFoundAgainWhateverTheAlignmentDriftAndScale) {
  const estimator::Pose2 lever{0.12, -0.03, 0.05};
  const Trajectory car = wavy_drive(0.0, 20.0, 0.01);
  Trajectory reference = car;
  for (auto& point : reference.points) point.pose = compose(point.pose, lever);
  Trajectory estimate = moved_by({-3.0, 1.0, 1.0}, car);
  for (auto& point : estimate.points) {  // a scale error of 2 %
    point.pose.x *= 1.02;
    point.pose.y *= 1.02;
  }
  const std::vector<Trajectory> estimates{estimate};
  const LeverArmFit fit = fit_lever_arm(reference, estimates);
  expect_near(fit.lever_arm, lever, 1e-4);
  EXPECT_GT(fit.windows, 100U);
}

TEST(LeverArm, IsTakenOutOfPoseAndVelocity) {
  const estimator::Pose2 lever{0.12, -0.03, 0.05};
  const Trajectory car = wavy_drive(0.0, 2.0, 0.01);
  Trajectory reference = car;
  for (auto& point : reference.points) {
    point.pose = compose(point.pose, lever);
    // v_point = R(-lever yaw) (v + yaw_rate × lever)
    const Motion v = point.motion;
    const double x = v.vx - v.yaw_rate * lever.y;
    const double y = v.vy + v.yaw_rate * lever.x;
    point.motion.vx = std::cos(lever.yaw) * x + std::sin(lever.yaw) * y;
    point.motion.vy = -std::sin(lever.yaw) * x + std::cos(lever.yaw) * y;
  }
  const Trajectory back = at_centre_of_gravity(reference, lever);
  for (std::size_t i = 0; i < car.points.size(); ++i) {
    expect_near(back.points[i].pose, car.points[i].pose, 1e-13);
    EXPECT_NEAR(back.points[i].motion.vx, car.points[i].motion.vx, 1e-13);
    EXPECT_NEAR(back.points[i].motion.vy, car.points[i].motion.vy, 1e-13);
  }
}

TEST(LeverArm, CannotBeFittedToAStraightDrive) {
  Trajectory straight = wavy_drive(0.0, 20.0, 0.01);
  for (auto& point : straight.points) {
    point.pose = {1e-9 * static_cast<double>(point.t_ns), 0.0, 0.0};
  }
  const std::vector<Trajectory> estimates{straight};
  EXPECT_THAT(message_of([&] { (void)fit_lever_arm(straight, estimates); }),
              HasSubstr("turns too little to fit a lever arm"));
}

Trajectory late_by(double seconds, Trajectory trajectory) {
  for (auto& point : trajectory.points)
    point.t_ns += static_cast<std::int64_t>(std::llround(seconds * 1e9));
  return trajectory;
}

const Trajectory truth = wavy_drive(0.0, 20.0, 0.01);

/// Like an estimate with camera poses: within a centimetre, without drift.
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

/// Like dead reckoning: the gyro over-reads and has a bias, the wheels are too small.
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
  for (auto& point : large_wheels.points) {  // drives straight, with a growing lead
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
  // Turns 0.1 s before the car and by a fifth more, like a kinematic model whose tyres slip.
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
}  // namespace odomd::tools::alignment_test
