#include "tools/evaluation/evaluation.hpp"

#include <numbers>

#include "tests/tools/drives.hpp"
#include "tools/evaluation/evaluation_report.hpp"

namespace odomd::tools::evaluation_test {
namespace {

TEST(Evaluation, OfTheReferenceItselfIsZero) {
  const Trajectory drive = wavy_drive(0.0, 5.0, 0.005);
  for (const Align align : {Align::first, Align::fit, Align::none}) {
    const Evaluation e = evaluate(drive, drive, align);
    EXPECT_NEAR(e.end_error, 0.0, 1e-12);
    EXPECT_NEAR(e.heading.max, 0.0, 1e-12);
    EXPECT_NEAR(e.position.max, 0.0, 1e-12);
    EXPECT_NEAR(error_over(e, short_horizon_ns)->displacement.max, 0.0, 1e-12);
    EXPECT_NEAR(e.path_length, 5.0, 1e-4);
    EXPECT_EQ(e.samples, 1001U);
  }
}

TEST(Evaluation, OfAScaleErrorHasTheFiguresOfThePaper) {
  // 1 % too far over 10 m: 10 cm at the end, 1 cm/m, 0.35 mm in 35 ms, rms = 0.1/√3 of a ramp.
  const Evaluation e =
      evaluate(arc_drive(1.0, 0.0, 10.0, 0.01), arc_drive(1.01, 0.0, 10.0, 0.005), Align::first);
  EXPECT_NEAR(e.path_length, 10.0, 1e-9);
  EXPECT_NEAR(e.end_error, 0.1, 1e-9);
  EXPECT_NEAR(e.end_cm_per_m.value(), 1.0, 1e-9);
  EXPECT_NEAR(e.position.max, 0.1, 1e-9);
  EXPECT_NEAR(e.position.rms, 0.1 / std::sqrt(3.0), 1e-4);
  EXPECT_NEAR(error_over(e, short_horizon_ns)->displacement.mean, 0.35e-3, 1e-9);
  EXPECT_NEAR(error_over(e, short_horizon_ns)->displacement.rms, 0.35e-3, 1e-9);
  EXPECT_EQ(error_over(e, short_horizon_ns)->samples, e.samples - 7);  // seven ticks of 5 ms
}

TEST(Evaluation, AccumulatesHeadingOverWholeTurns) {
  const Trajectory drive = wavy_drive(0.0, 30.0, 0.01);  // nine radians in all
  Trajectory estimate = drive;
  for (auto& point : estimate.points) {
    point.pose.yaw += 0.2 * 1e-9 * static_cast<double>(point.t_ns);  // ends six radians off
    point.pose.yaw += 4.0 * std::numbers::pi;  // and counts its turns from another start
  }
  const Evaluation e = evaluate(drive, estimate, Align::none);
  EXPECT_NEAR(e.heading_end, 6.0, 1e-9);
  EXPECT_NEAR(e.heading.max, 6.0, 1e-9);
  EXPECT_NEAR(e.heading.rms, 6.0 / std::sqrt(3.0), 1e-2);
}

TEST(Evaluation, DropsWholeTurnsAtAReset) {
  const Trajectory drive = wavy_drive(0.0, 30.0, 0.01);
  Trajectory estimate = drive;
  for (auto& point : estimate.points) {
    if (point.t_ns < 10'000'000'000) {
      point.pose.yaw += 0.2 * 1e-9 * static_cast<double>(point.t_ns);
    } else {  // after the reset: 0.1 rad off, and a turn less
      point.pose.yaw += 0.1 - 2.0 * std::numbers::pi;
      point.reset_count = 1.0;
    }
  }
  const Evaluation e = evaluate(drive, estimate, Align::none);
  EXPECT_NEAR(e.heading_end, 0.1, 1e-9);
  EXPECT_NEAR(e.heading.max, 2.0, 0.01);
}

TEST(Evaluation, CoversOnlyTheCommonSpan) {
  const Evaluation e =
      evaluate(wavy_drive(1.0, 3.0, 0.01), wavy_drive(2.0, 9.0, 0.005), Align::first);
  EXPECT_EQ(e.first_ns, 2'000'000'000);
  EXPECT_EQ(e.last_ns, 3'000'000'000);
  EXPECT_EQ(e.samples, 201U);
  EXPECT_NEAR(e.path_length, 1.0, 1e-4);
}

TEST(Evaluation, HasNoRelativeErrorIfTheReferenceStands) {
  Trajectory reference = arc_drive(0.0, 0.0, 1.0, 0.01);
  const Evaluation still = evaluate(reference, arc_drive(0.1, 0.0, 1.0, 0.01), Align::first);
  EXPECT_EQ(still.path_length, 0.0);
  EXPECT_FALSE(still.end_cm_per_m);
  EXPECT_NEAR(still.end_error, 0.1, 1e-12);
  for (std::size_t i = 0; i < reference.points.size(); i += 2) reference.points[i].pose.y = 0.02;
  const Evaluation noisy = evaluate(reference, arc_drive(0.1, 0.0, 1.0, 0.01), Align::none);
  EXPECT_GT(noisy.path_length, 1.9);
  EXPECT_FALSE(noisy.end_cm_per_m);
}

TEST(Evaluation, NeesCountsErrorsInTheirOwnSigmas) {
  const Trajectory reference = arc_drive(1.0, 0.0, 2.0, 0.01);
  Trajectory estimate = reference;
  estimate.has_covariance = true;
  for (auto& point : estimate.points) {
    point.pose.x += 0.2;    // two sigmas: 4
    point.pose.yaw += 0.1;  // one sigma: 1
    point.covariance = {0.01, 0.0, 0.0, 0.04, 0.0, 0.01};
  }
  const Evaluation e = evaluate(reference, estimate, Align::none);
  ASSERT_TRUE(e.consistency);
  EXPECT_NEAR(e.consistency->nees, 5.0, 1e-9);
  EXPECT_EQ(e.consistency->samples, e.samples);
}

TEST(Evaluation, HasNoNeesIfTheAlignmentRemovesAnUncertainStart) {
  const Trajectory reference = arc_drive(1.0, 0.0, 2.0, 0.01);
  Trajectory estimate = reference;
  estimate.has_covariance = true;
  for (auto& point : estimate.points) point.covariance = {0.01, 0.0, 0.0, 0.01, 0.0, 0.01};
  EXPECT_TRUE(evaluate(reference, estimate, Align::none).consistency);
  EXPECT_FALSE(evaluate(reference, estimate, Align::first).consistency);
  EXPECT_FALSE(evaluate(reference, estimate, Align::fit).consistency);
  estimate.points.front().covariance = {1e-5, 0.0, 0.0, 1e-5, 0.0, 1e-5};
  EXPECT_TRUE(evaluate(reference, estimate, Align::first).consistency);
  EXPECT_FALSE(evaluate(reference, estimate, Align::fit).consistency);
}

TEST(Evaluation, NeesRotatesTheCovarianceWithTheMapAndSkipsSingularOnes) {
  // The estimate's map is rotated by 90°: its sigma along x lies along the reference's y.
  const Trajectory reference = arc_drive(1.0, 0.0, 2.0, 0.01);
  Trajectory estimate = moved_by({0.0, 0.0, -std::numbers::pi / 2.0}, reference);
  estimate.has_covariance = true;
  for (auto& point : estimate.points) point.covariance = {1.0, 0.0, 0.0, 0.01, 0.0, 1.0};
  estimate.points.front().covariance = {};
  // 0.2 along the reference's x lies along the estimate's -y: two sigmas.
  for (std::size_t i = 1; i < estimate.points.size(); ++i) estimate.points[i].pose.y -= 0.2;
  const Evaluation e = evaluate(reference, estimate, Align::first);
  ASSERT_TRUE(e.consistency);
  EXPECT_NEAR(e.consistency->nees, 4.0, 1e-9);
  EXPECT_EQ(e.consistency->samples, e.samples - 1);
}

TEST(Evaluation, ComparesVelocitiesWhereBothHaveThem) {
  const Trajectory reference = wavy_drive(0.0, 1.0, 0.01);
  Trajectory estimate = reference;
  for (auto& point : estimate.points) point.motion.v_y += 0.25;
  const Evaluation e = evaluate(reference, estimate, Align::none);
  ASSERT_TRUE(e.velocity_rms);
  EXPECT_NEAR(e.velocity_rms->v_x, 0.0, 1e-12);
  EXPECT_NEAR(e.velocity_rms->v_y, 0.25, 1e-12);
  estimate.has_motion = false;
  EXPECT_FALSE(evaluate(reference, estimate, Align::none).velocity_rms);
}

TEST(Evaluation, SeesAReferenceThatHasLostTheCarOrJumps) {
  const Trajectory drive = wavy_drive(0.0, 9.0, 0.01);
  Trajectory lost = drive;
  const auto& last_seen = drive.points[300];
  for (auto& point : lost.points) {
    if (point.t_ns > 3'000'000'000 && point.t_ns < 5'000'000'000) {
      point.pose = last_seen.pose;
      point.pose.x += 1e-4 * std::sin(static_cast<double>(point.t_ns));  // tracker jitter
    }
  }
  const Evaluation e = evaluate(lost, drive, Align::none);
  EXPECT_NEAR(static_cast<double>(e.reference_stuck_ns), 2e9, 2e7);
  EXPECT_EQ(evaluate(drive, drive, Align::none).reference_stuck_ns, 0);
  EXPECT_EQ(evaluate(lost, lost, Align::none).reference_stuck_ns, 0);  // the estimate is stuck, too
  Trajectory elsewhere = lost;  // off by 3 m until its filter jumps
  for (auto& point : elsewhere.points) {
    point.reset_count = point.t_ns < 4'000'000'000 ? 1.0 : 2.0;
    if (point.t_ns < 4'000'000'000) point.pose.y += 3.0;
  }
  EXPECT_EQ(evaluate(lost, elsewhere, Align::none).reference_stuck_ns, 0);
  Trajectory reference = arc_drive(1.0, 0.0, 2.0, 0.01);
  reference.points[100].pose.x += 5.0;  // there and back
  EXPECT_EQ(evaluate(reference, arc_drive(1.0, 0.0, 2.0, 0.01), Align::first).reference_jumps, 2U);
}

TEST(Improvement, IsInPercentOfTheBaseline) {
  EXPECT_NEAR(improvement(0.174, 1.0).value(), 82.6, 1e-9);
  EXPECT_FALSE(improvement(3.2, 0.01, 2.0));  // the baseline's end error is almost 0
  EXPECT_TRUE(improvement(3.2, 0.5, 2.0));
  const auto text = [](std::optional<double> value) {
    return text_of(value, "end error better by [%]", 1);
  };
  EXPECT_EQ(text(improvement(2.0, 1.0)), "-100.0");
  EXPECT_EQ(text(improvement(20.0, 1.0)), "< -999");
  EXPECT_EQ(text(improvement(1.0, 0.0)), "-");
  EXPECT_EQ(text_of(-1000.0, "vx rms [m/s]", 1), "-1000.0");
}

TEST(Improvement, IsAlwaysInTheUnitOfItsRow) {
  EvaluationReport report;
  report.evaluations.resize(3);
  const std::array errors{0.1, 0.0174, 45.0};
  for (std::size_t i = 0; i < errors.size(); ++i)
    report.evaluations[i].end_error = report.evaluations[i].position.rms = errors[i];
  int rows = 0;
  for (const auto& row : metrics_table(report).rows) {
    if (!row.front().ends_with("[%]")) continue;
    EXPECT_THAT(row, ElementsAre(row.front(), "-", "82.6", "< -999"));
    ++rows;
  }
  EXPECT_GE(rows, 2);
}

TEST(EvaluationReport, HasAnglesInDegreesAndOnlyAgainstACameraItsNoise) {
  Evaluation e;
  e.heading.rms = std::numbers::pi;
  EXPECT_EQ(metric("heading error rms [deg]").value(e, e), 180.0);
  const auto json_against = [&e](Against against) {
    e.against = against;
    return json_of(EvaluationReport{.evaluations = {e}}).dump();
  };
  EXPECT_THAT(json_against(Against::camera), HasSubstr("reference_noise"));
  EXPECT_THAT(json_against(Against::reference), Not(HasSubstr("reference_noise")));
}

TEST(ShortNames, AreStemsUnlessTheyWouldBeAlike) {
  EXPECT_THAT(short_names({"a/kin.csv", "b/paper.csv"}), ElementsAre("kin", "paper"));
  EXPECT_THAT(short_names({"a/pose.csv", "b/pose.csv"}), ElementsAre("a/pose.csv", "b/pose.csv"));
}

}  // namespace
}  // namespace odomd::tools::evaluation_test
