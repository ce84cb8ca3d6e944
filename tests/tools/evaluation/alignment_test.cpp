// Comparison of poses with a reference: alignment, lever arm, time offset, and errors.
#include <numbers>

#include "tests/estimator/drive.hpp"
#include "tests/tools/drives.hpp"
#include "tools/evaluation/evaluation.hpp"
#include "tools/evaluation/evaluation_checks.hpp"
#include "tools/math/se2.hpp"

namespace odomd::tools::alignment_test {
namespace {

using estimator::testing::PoseNear;

TEST(Alignment, FirstAndFitBothUndoARigidMotion) {
  const Trajectory reference = wavy_drive(0.0, 10.0, 0.01);
  const estimator::Pose2 away{5.0, -2.0, 2.5};
  const Trajectory estimate = moved_by(inverse(away), reference);
  const auto pairs = common_times(reference, estimate);
  EXPECT_THAT(alignment(pairs, Align::first), PoseNear(away, 1e-12));
  EXPECT_THAT(alignment(pairs, Align::fit), PoseNear(away, 1e-12));
  EXPECT_THAT(alignment(pairs, Align::none), PoseNear(estimator::Pose2{}, 0.0));
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

TEST(Alignment, FitOfAStandingCarUsesTheHeadingsForTheRotation) {
  Trajectory reference = wavy_drive(0.0, 1.0, 0.01);
  for (auto& point : reference.points) point.pose = {2.0, 1.0, 0.7};
  Trajectory estimate = reference;
  for (auto& point : estimate.points) point.pose = {0.0, 0.0, 0.2};
  EXPECT_THAT(alignment(common_times(reference, estimate), Align::fit),
              PoseNear(estimator::Pose2{2.0, 1.0, 0.5}, 1e-12));
}

TEST(LeverArm, IsFoundDespiteAlignmentDriftAndScale) {
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
  EXPECT_THAT(fit.lever_arm, PoseNear(lever, 1e-4));
  EXPECT_GT(fit.windows, 100U);
}

TEST(LeverArm, IsRemovedFromPoseAndVelocity) {
  const estimator::Pose2 lever{0.12, -0.03, 0.05};
  const Trajectory car = wavy_drive(0.0, 2.0, 0.01);
  Trajectory reference = car;
  for (auto& point : reference.points) {
    point.pose = compose(point.pose, lever);
    // v_point = R(-lever yaw) (v + yaw_rate × lever)
    const auto v = point.motion;
    const double x = v.v_x - v.yaw_rate * lever.y;
    const double y = v.v_y + v.yaw_rate * lever.x;
    point.motion.v_x = std::cos(lever.yaw) * x + std::sin(lever.yaw) * y;
    point.motion.v_y = -std::sin(lever.yaw) * x + std::cos(lever.yaw) * y;
  }
  const Trajectory back = at_centre_of_gravity(reference, lever);
  for (std::size_t i = 0; i < car.points.size(); ++i) {
    EXPECT_THAT(back.points[i].pose, PoseNear(car.points[i].pose, 1e-13));
    EXPECT_NEAR(back.points[i].motion.v_x, car.points[i].motion.v_x, 1e-13);
    EXPECT_NEAR(back.points[i].motion.v_y, car.points[i].motion.v_y, 1e-13);
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

TEST(TimeOffset, IsFoundForAnEstimateThatDoesNotDrift) {
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

TEST(TimeOffset, IsFoundForAnEstimateThatDrifts) {
  for (const double late : {-0.15, -0.1, 0.1, 0.15}) {
    const auto found = offset_by_motion(late_by(late, truth), drifting());
    ASSERT_TRUE(found) << late;
    EXPECT_NEAR(found->late_s, late, 0.01);
  }
  EXPECT_FALSE(offset_by_motion(truth, drifting()));
}

TEST(TimeOffset, IsNotReportedForAWrongWheelLeverArmOrHeading) {
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

TEST(TimeOffset, IsNotReportedForSteeringAheadOfTheCar) {
  // The estimate turns 0.1 s early and by a fifth more, like a kinematic model, which has no slip.
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

TEST(TimeOffset, IsNotReportedForAStandingCarOrAShortDrive) {
  Trajectory standing = truth;
  for (auto& point : standing.points) point.pose = {1.0, 2.0, 0.5};
  EXPECT_FALSE(offset_by_positions(standing, standing, Align::none));
  EXPECT_FALSE(offset_by_motion(standing, standing));
  const Trajectory little = wavy_drive(5.0, 5.2, 0.005);
  EXPECT_FALSE(offset_by_positions(late_by(0.1, truth), little, Align::none));
  EXPECT_FALSE(offset_by_motion(late_by(0.1, truth), little));
  EXPECT_FALSE(offset_by_motion(little, late_by(0.1, truth)));
}

constexpr std::int64_t tick = 5'000'000;

TEST(HorizonErrors, OfAGyroErrorAreTheDistanceBetweenTwoChords) {
  // Both at 1 m/s; ψ̇ 0.5 and 0.6 rad/s. In the body frame of the start, each moves by v/ω (sin ωT,
  // 1 − cos ωT).
  const auto chord = [](double rate, double t) {
    return std::pair{std::sin(rate * t) / rate, (1.0 - std::cos(rate * t)) / rate};
  };
  const Trajectory slower = arc_drive(1.0, 0.5, 2.0, 0.005);
  const Trajectory estimate = arc_drive(1.0, 0.6, 2.0, 0.005);
  const auto errors = horizon_errors(slower, estimate, common_times(slower, estimate));
  ASSERT_EQ(errors.size(), horizons_ns.size());
  for (const HorizonError& e : errors) {
    EXPECT_EQ(e.samples, 401U - static_cast<std::size_t>(e.horizon_ns / tick));
    const double t = 1e-9 * static_cast<double>(e.horizon_ns);
    const auto [x, y] = chord(0.6, t);
    const auto [x_true, y_true] = chord(0.5, t);
    const double apart = std::hypot(x - x_true, y - y_true);
    EXPECT_NEAR(e.displacement.rms, apart, 1e-9);
    EXPECT_NEAR(e.displacement.mean, apart, 1e-9);
    EXPECT_NEAR(e.displacement.max, apart, 1e-9);
    EXPECT_NEAR(e.yaw.mean, 0.1 * t, 1e-9);
  }
}

TEST(HorizonErrors, LeaveOutHorizonsThatAreLongerThanTheDrive) {
  const Trajectory drive = arc_drive(1.0, 0.3, 0.1, 0.005);
  const auto errors = horizon_errors(drive, drive, common_times(drive, drive));
  ASSERT_EQ(errors.size(), 6U);
  EXPECT_EQ(errors.back().horizon_ns, 100'000'000);
  EXPECT_EQ(errors.back().samples, 1U);
}

TEST(PoseErrors, LieAlongAndAcrossTheReferencesHeading) {
  // The reference faces north; the estimate is 3 m ahead and 1 m to its left.
  TrajectoryPoint reference;
  reference.pose = {10.0, 20.0, std::numbers::pi / 2.0};
  TrajectoryPoint estimate;
  estimate.pose = {9.0, 23.0, std::numbers::pi / 2.0 + 0.1};
  estimate.covariance = {0.01, 0.0, 0.0, 0.04, 0.0, 0.09};
  const std::vector<Pair> pairs{{estimate, reference}};
  const DrivenError e = driven(pose_errors(pairs, {}, true).front());
  EXPECT_NEAR(e.along, 3.0, 1e-12);
  EXPECT_NEAR(e.cross, 1.0, 1e-12);
  EXPECT_NEAR(e.yaw, 0.1, 1e-12);
  EXPECT_NEAR(e.sigma_along, 0.2, 1e-12);  // the map's y
  EXPECT_NEAR(e.sigma_cross, 0.1, 1e-12);
  EXPECT_NEAR(e.sigma_yaw, 0.3, 1e-12);
}

// A circle of 2 m radius, driven for this many turns.
Trajectory lap(double turns) {
  return arc_drive(2.0, 1.0, turns * 2.0 * std::numbers::pi, 0.005);
}

TEST(ClosedLoop, IsComparedWithItsOwnStart) {
  const Evaluation e = evaluate_closed_loop(lap(1.01));
  EXPECT_EQ(e.against, Against::closed_loop);
  EXPECT_NEAR(e.path_length, 2.0 * 1.01 * 2.0 * std::numbers::pi, 0.02);
  EXPECT_NEAR(e.end_error, 4.0 * std::sin(0.01 * std::numbers::pi), 0.01);
  EXPECT_NEAR(e.heading_end, 0.01 * 2.0 * std::numbers::pi, 0.01);  // not a whole turn more
  EXPECT_NEAR(e.end_cm_per_m.value(), 100.0 * e.end_error / e.path_length, 1e-12);
  EXPECT_EQ(error_over(e, short_horizon_ns), nullptr);
  EXPECT_FALSE(check_that_it_closes("lap", std::vector{e}));
}

TEST(ClosedLoop, GivesAWarningIfItClosesBadlyAndAnErrorIfItDoesNotClose) {
  const auto verdict = [](double turns) {
    return message_of([turns] {
      const auto warning =
          check_that_it_closes("lap", std::vector{evaluate_closed_loop(lap(turns))});
      if (warning) throw std::runtime_error(std::string{warning->kind->name});
    });
  };
  EXPECT_EQ(verdict(1.02), "");
  EXPECT_EQ(verdict(0.93), "loop_closes_badly");
  EXPECT_THAT(
      verdict(0.8),
      AllOf(HasSubstr("lap: the lap does not close: according to the best estimate it ends 2.35 m"),
            HasSubstr("--from and --to, or give a --reference")));
  EXPECT_THAT(verdict(0.01), HasSubstr("the car hardly moves"));
}

TEST(ClosedLoop, IsJudgedByTheBestOfTheEstimates) {
  const std::vector<Evaluation> both{evaluate_closed_loop(lap(0.7)),
                                     evaluate_closed_loop(lap(1.0))};
  EXPECT_FALSE(check_that_it_closes("lap", both));
}

TEST(ClosedLoop, IsWarnedOfATurnAbove20Degrees) {
  for (const double degrees : {-21.0, 19.0, 21.0}) {
    Evaluation e = evaluate_closed_loop(lap(1.0));
    e.heading_end = degrees * std::numbers::pi / 180.0;
    EXPECT_EQ(check_that_it_closes("lap", std::vector{e}).has_value(), std::abs(degrees) > 20.0);
  }
}

}  // namespace
}  // namespace odomd::tools::alignment_test
