// Fitted values tried on the filter: what helps is taken, what harms is left.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tests/tools/scratch.hpp"
#include "tools/drive_files/camera_csv.hpp"
#include "tools/identify/common/delivery.hpp"
#include "tools/identify/fit/choice.hpp"
#include "tools/identify/fit/judge.hpp"
#include "tools/identify/fit/reference.hpp"
#include "tools/identify/fit/trial.hpp"

namespace odomd::tools::fitting::fit_trial_test {
namespace {

using testing::HasSubstr;

TEST(Smoothed, FollowsACurveThroughNoiseAndForgetsAnOutlier) {
  std::vector<estimator::CameraPose> poses;
  for (int k = 0; k < 100; ++k) {
    const double t = 0.03 * k;
    estimator::CameraPose pose;
    pose.capture_ns = 30'000'000LL * k;
    pose.x = std::sin(t) + 0.004 * (k % 2 == 0 ? 1.0 : -1.0);
    pose.y = std::cos(t) + (k == 50 ? 0.5 : 0.0);
    pose.yaw = std::remainder(3.0 + t, 6.283185307179586);
    pose.sigma_x = pose.sigma_y = 0.005;
    pose.sigma_yaw = 0.01;
    poses.push_back(pose);
  }
  const Trajectory way = smoothed(poses, 0.25);
  ASSERT_GT(way.points.size(), 100U);
  for (const TrajectoryPoint& point : way.points) {
    const double t = 1e-9 * static_cast<double>(point.t_ns);
    EXPECT_NEAR(point.pose.x, std::sin(t), 4e-3) << t;
    EXPECT_NEAR(point.pose.y, std::cos(t), 0.03) << t;
    EXPECT_NEAR(point.pose.yaw, 3.0 + t, 1e-3) << t;
  }
}

TEST(Smoothed, HasNoPointsWherePosesAreMissing) {
  std::vector<estimator::CameraPose> poses;
  for (int k = 0; k < 200; ++k) {
    estimator::CameraPose pose;
    pose.capture_ns = 20'000'000LL * k + (k < 100 ? 0 : 1'000'000'000LL);
    pose.sigma_x = pose.sigma_y = pose.sigma_yaw = 0.01;
    poses.push_back(pose);
  }
  for (const TrajectoryPoint& point : smoothed(poses, 0.25).points)
    EXPECT_FALSE(point.t_ns > 2'060'000'000 && point.t_ns < 2'920'000'000) << point.t_ns;
}

class Trial : public testing::Test {
 protected:
  Trial() {
    const Outcome made =
        run_shell("cd " + scratch_.path("").string() +
                  " && odom sim --duration 16 --out lap && sed -i /^accel/d lap/car.toml");
    if (made.status != 0) throw std::runtime_error(made.err);
    config_ = daemon::load_config(scratch_.path("lap/car.toml"));
    const std::vector<std::string> logs{scratch_.path("lap/drive.log").string()};
    drives_.push_back(trial_drive(
        "lap", config_, logs, read_camera_log(scratch_.path("lap/camera.csv")).poses, 0.0, 1e9));
  }
  [[nodiscard]] Findings tried(Findings findings) const {
    findings.method = "fit";
    try_out(findings, drives_, {});
    return findings;
  }
  Scratch scratch_;
  daemon::Config config_;
  std::vector<tools::Drive> drives_;
};

TEST_F(Trial, PosesOfAfterTheLogAreNoPartOfIt) {
  std::vector<estimator::CameraPose> poses = read_camera_log(scratch_.path("lap/camera.csv")).poses;
  const std::int64_t end = poses.back().capture_ns;
  for (std::int64_t k = 1; k <= 1000; ++k) {
    poses.push_back(poses.back());
    poses.back().capture_ns = poses.back().arrival_ns = end + 35'000'000 * k;
  }
  const std::vector<std::string> logs{scratch_.path("lap/drive.log").string()};
  drives_ = {trial_drive("lap", config_, logs, poses, 0.0, 1e9)};
  EXPECT_LE(drives_[0].reference->points.back().t_ns, drives_[0].frames.back().time_ns);
  EXPECT_NO_THROW((void)tried({}));
}

TEST_F(Trial, WhatHarmsIsLeftAsConfiguredAndSaysWhy) {
  const Findings findings = tried({.method = "",
                                   .origin = "",
                                   .values = {{.name = "gyro scale",
                                               .key = "can.signals.yaw_rate.scale",
                                               .value = 0.8,
                                               .sigma = 0.01,
                                               .unit = "",
                                               .remark = ""},
                                              {.name = "yaw inertia",
                                               .key = "vehicle.yaw_inertia",
                                               .value = config_.vehicle.yaw_inertia,
                                               .sigma = 1e-4,
                                               .unit = "kg m2",
                                               .remark = ""}},
                                   .warnings = {},
                                   .details = {}});
  EXPECT_EQ(findings.values[0].use, Use::leave);
  EXPECT_THAT(findings.values[0].remark, HasSubstr("left as configured: replayed"));
  EXPECT_THAT(as_json(findings).dump(), HasSubstr("\"left_as_configured\":true"));
  EXPECT_EQ(findings.values[1].use, Use::write);  // changes nothing
  EXPECT_TRUE(findings.details["trial"]["groups"]["yaw inertia"]["taken"]);
}

Candidate candidate(const std::string& name) {
  return {.name = name, .patch = {{name, 1.0, ""}}};
}

/// The errors by which of the candidates are in, of all parts alike.
Ratio errors(const Patch& patch, double (*error)(const std::set<std::string>& in)) {
  std::set<std::string> in;
  for (const ConfigValue& value : patch) in.insert(value.key);
  const double all = error(in);
  return {.all = all, .half = {all, all}};
}

TEST(Choice, LeavesAnExpedientAgainWhereTheCauseCameIn) {
  Choice choice(
      [](const Patch& patch) {
        return errors(patch, [](const std::set<std::string>& in) {
          if (!in.contains("expedient")) return in.contains("cause") ? 0.5 : 1.0;
          return in.contains("cause") ? 0.7 : 0.8;
        });
      },
      {candidate("cause"), candidate("harm that is none")});
  choice.take(candidate("expedient"), {.all = 0.8, .half = {0.8, 0.8}});
  EXPECT_EQ(choice.turn_best(), "cause");
  EXPECT_EQ(choice.turn_best(), "harm that is none");
  EXPECT_EQ(choice.turn_best(), "without expedient");
  EXPECT_EQ(choice.turn_best(), std::nullopt);
  EXPECT_EQ(choice.now().all, 0.5);
  EXPECT_EQ(choice.patch().size(), 2U);
}

TEST(Choice, KeepsAPartOnlyAsLongAsItIsWorthIt) {
  // What the trial found itself brings a fifth at first, and 0.4 % in the end.
  Candidate part = candidate("part");
  part.own = Finding{.name = "part"};
  Choice choice(
      [](const Patch& patch) {
        return errors(patch, [](const std::set<std::string>& in) {
          if (!in.contains("part")) return in.contains("cause") ? 0.5 : 1.0;
          return in.contains("cause") ? 0.498 : 0.8;
        });
      },
      {candidate("cause")});
  choice.take(part, {.all = 0.8, .half = {0.8, 0.8}});
  EXPECT_EQ(choice.turn_best(), "cause");
  EXPECT_EQ(choice.turn_best(), "without part");
  EXPECT_EQ(choice.turn_best(), std::nullopt);
}

TEST(Choice, TakesNothingThatHarmsAHalf) {
  Choice choice(
      [](const Patch& patch) {
        Ratio ratio{.all = 1.0, .half = {1.0, 1.0}};
        if (!patch.empty()) ratio = {.all = 0.8, .half = {1.2, 0.5}};
        return ratio;
      },
      {candidate("half")});
  EXPECT_EQ(choice.turn_best(), std::nullopt);
  EXPECT_EQ(choice.turned(0).all, 0.8);
  EXPECT_TRUE(choice.patch().empty());
}

TEST_F(Trial, ADriveWithoutPosesIsRefused) {
  const std::vector<std::string> logs{scratch_.path("lap/drive.log").string()};
  EXPECT_THROW((void)trial_drive("lap", config_, logs, {}, 0.0, 1e9), std::invalid_argument);
}

}  // namespace
}  // namespace odomd::tools::fitting::fit_trial_test
