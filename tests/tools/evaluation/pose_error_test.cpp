#include "tools/evaluation/pose_error.hpp"

#include <numbers>

#include "tests/gtest.hpp"
#include "tests/tools/drives.hpp"
#include "tools/evaluation/evaluation.hpp"

namespace odomd::tools::pose_error_test {
namespace {

constexpr std::int64_t tick = 5'000'000;

// Along x at a speed and a yaw rate: rows of 5 ms.
Trajectory turning(double speed, double rate, int rows) {
  Trajectory drive;
  drive.name = "turning.csv";
  for (int i = 0; i < rows; ++i) {
    const double t = 0.005 * i;
    TrajectoryPoint point;
    point.t_ns = i * tick;
    // ∫ v (cos ωt, sin ωt)
    point.pose = rate == 0.0
                     ? estimator::Pose2{speed * t, 0.0, 0.0}
                     : estimator::Pose2{speed / rate * std::sin(rate * t),
                                        speed / rate * (1.0 - std::cos(rate * t)), rate * t};
    drive.points.push_back(point);
  }
  return drive;
}

TEST(HorizonErrors, OfAGyroErrorAreAChordNextToAnother) {
  // Both at 1 m/s; ψ̇ 0.5 and 0.6 rad/s. In the body frame of the start, each moves by v/ω (sin ωT,
  // 1 − cos ωT).
  const auto chord = [](double rate, double t) {
    return std::pair{std::sin(rate * t) / rate, (1.0 - std::cos(rate * t)) / rate};
  };
  const Trajectory truth = turning(1.0, 0.5, 401);
  const Trajectory estimate = turning(1.0, 0.6, 401);
  const auto errors = horizon_errors(truth, estimate, common_times(truth, estimate));
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
  const Trajectory drive = turning(1.0, 0.3, 21);  // 100 ms
  const auto errors = horizon_errors(drive, drive, common_times(drive, drive));
  ASSERT_EQ(errors.size(), 6U);
  EXPECT_EQ(errors.back().horizon_ns, 100'000'000);
  EXPECT_EQ(errors.back().samples, 1U);
}

TEST(PoseErrors, LieAlongAndAcrossTheReferencesHeading) {
  // The reference faces north; the estimate is 3 m ahead and 1 m to its left.
  TrajectoryPoint truth;
  truth.pose = {10.0, 20.0, std::numbers::pi / 2.0};
  TrajectoryPoint estimate;
  estimate.pose = {9.0, 23.0, std::numbers::pi / 2.0 + 0.1};
  estimate.covariance = {0.01, 0.0, 0.0, 0.04, 0.0, 0.09};
  const std::vector<Pair> pairs{{estimate, truth}};
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
  return turning(2.0, 1.0,
                 1 + static_cast<int>(std::lround(turns * 2.0 * std::numbers::pi / 0.005)));
}

TEST(ClosedLoop, IsHeldAgainstItsOwnStart) {
  const Evaluation e = evaluate_closed_loop(lap(1.01));
  EXPECT_EQ(e.against, Against::closed_loop);
  EXPECT_NEAR(e.path_length, 2.0 * 1.01 * 2.0 * std::numbers::pi, 0.02);
  EXPECT_NEAR(e.end_error, 4.0 * std::sin(0.01 * std::numbers::pi), 0.01);
  EXPECT_NEAR(e.heading_end, 0.01 * 2.0 * std::numbers::pi, 0.01);  // not a whole turn more
  EXPECT_NEAR(e.end_cm_per_m.value(), 100.0 * e.end_error / e.path_length, 1e-12);
  EXPECT_EQ(error_over(e, short_horizon_ns), nullptr);
  EXPECT_FALSE(check_that_it_closes("lap", std::vector{e}));
}

TEST(ClosedLoop, ThatClosesBadlyGivesAWarningAndOneThatDoesNotIsRefused) {
  const auto verdict = [](double turns) {
    return message_of([turns] {
      const auto warning =
          check_that_it_closes("lap", std::vector{evaluate_closed_loop(lap(turns))});
      if (warning) throw std::runtime_error(std::string{warning->kind->name});
    });
  };
  EXPECT_EQ(verdict(1.02), "");
  EXPECT_EQ(verdict(0.93), "loop_closes_badly");
  EXPECT_THAT(verdict(0.8),
              AllOf(HasSubstr("lap: the lap does not close: by the best estimate it ends 2.35 m"),
                    HasSubstr("--from and --to, or give a --reference")));
  EXPECT_THAT(verdict(0.01), HasSubstr("the car hardly moves"));
}

TEST(ClosedLoop, IsJudgedByTheBestOfTheEstimates) {
  const std::vector<Evaluation> both{evaluate_closed_loop(lap(0.7)),
                                     evaluate_closed_loop(lap(1.0))};
  EXPECT_FALSE(check_that_it_closes("lap", both));
}

}  // namespace
}  // namespace odomd::tools::pose_error_test
