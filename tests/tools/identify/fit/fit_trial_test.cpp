// Fitted values tried on the filter: those that help are kept.
#include <set>

#include "tests/tools/scratch.hpp"
#include "tools/drive_files/drive_tables.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/identify/fit/trial.hpp"

namespace odomd::tools::fitting::fit_trial_test {
namespace {

TEST(Smoothed, FollowsACurveThroughNoiseAndIgnoresAnOutlier) {
  std::vector<estimator::CameraPose> poses;
  for (int k = 0; k < 100; ++k) {
    const double t = 0.03 * k;
    const double noise = k % 2 == 0 ? 0.004 : -0.004, outlier = k == 50 ? 0.5 : 0.0;
    poses.push_back({30'000'000LL * k, 0, std::sin(t) + noise, std::cos(t) + outlier,
                     std::remainder(3.0 + t, 6.283185307179586), 0.005, 0.005, 0.01});
  }
  const Trajectory path = smoothed(poses, 0.25);
  ASSERT_GT(path.points.size(), 100U);
  for (const TrajectoryPoint& point : path.points) {
    const double t = 1e-9 * static_cast<double>(point.t_ns);
    EXPECT_NEAR(point.pose.x, std::sin(t), 4e-3) << t;
    EXPECT_NEAR(point.pose.y, std::cos(t), 0.03) << t;
    EXPECT_NEAR(point.pose.yaw, 3.0 + t, 1e-3) << t;
  }
}

TEST(Smoothed, HasNoPointsWherePosesAreMissing) {
  std::vector<estimator::CameraPose> poses;
  for (int k = 0; k < 200; ++k)
    poses.push_back(
        {20'000'000LL * k + (k < 100 ? 0 : 1'000'000'000LL), 0, 0, 0, 0, 0.01, 0.01, 0.01});
  for (const TrajectoryPoint& point : smoothed(poses, 0.25).points)
    EXPECT_FALSE(point.t_ns > 2'060'000'000 && point.t_ns < 2'920'000'000) << point.t_ns;
}

class Trial : public testing::Test {
 protected:
  Trial() {
    simulate(scratch_, "--duration 16", "lap");
    scratch_.must_run("sed -i /^accel/d lap/car.toml");
    config_ = daemon::load_config(scratch_.path("lap/car.toml"));
    const tools::Drive drive = read_drive({.folder = scratch_.path("lap")});
    drives_.push_back(trial_drive(drive, drive.cameras));
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

TEST_F(Trial, LeavesOutPosesAfterTheLogAndRefusesNoPoses) {
  std::vector<estimator::CameraPose> poses = read_camera_log(scratch_.path("lap/camera.csv")).poses;
  const std::int64_t end = poses.back().capture_ns;
  for (std::int64_t k = 1; k <= 1000; ++k) {
    poses.push_back(poses.back());
    poses.back().capture_ns = poses.back().arrival_ns = end + 35'000'000 * k;
  }
  drives_ = {trial_drive(read_drive({.folder = scratch_.path("lap")}), poses)};
  EXPECT_LE(drives_[0].reference->points.back().t_ns, drives_[0].frames.back().time_ns);
  EXPECT_NO_THROW((void)tried({}));
  EXPECT_THROW((void)trial_drive(drives_[0], {}), std::invalid_argument);
}

TEST_F(Trial, LeavesHarmfulValuesAsConfiguredWithTheReason) {
  const Findings findings =
      tried({.values = {{.key = "can.signals.yaw_rate.scale", .value = 0.8},
                        {.key = "vehicle.yaw_inertia", .value = config_.vehicle.yaw_inertia}}});
  EXPECT_EQ(findings.values[0].use, Use::leave);
  EXPECT_THAT(findings.values[0].remark, HasSubstr("left as configured: replayed"));
  EXPECT_THAT(as_json(findings).dump(), HasSubstr("\"left_as_configured\":true"));
  EXPECT_EQ(findings.values[1].use, Use::write);  // makes no difference
  EXPECT_TRUE(findings.details["trial"]["groups"]["yaw inertia"]["taken"]);
}

std::vector<Group> groups(const std::vector<std::string>& names) {
  std::vector<Group> all;
  for (const std::string& name : names) all.push_back({.name = name, .patch = {{name, 1.0, ""}}});
  return all;
}

/// The error as a function of the applied groups, the same in all parts of the drives.
template <typename Error>
Ratio errors(const Patch& patch, Error&& error) {
  std::set<std::string> in;
  for (const ConfigValue& value : patch) in.insert(value.key);
  const double all = error(in);
  return {.all = all, .half = {all, all}};
}

TEST(Choose, DropsAnExpedientOnceItsCauseIsAccepted) {
  std::vector<Group> all = groups({"expedient", "cause", "rest of it", "harm that is none"});
  std::vector<std::string> turns;
  const Ratio found = choose(
      all,
      [](const Patch& patch) {
        return errors(patch, [](const std::set<std::string>& in) {
          const std::size_t causes = in.count("cause") + in.count("rest of it");
          const std::array with{0.8, 0.75, 0.6}, without{1.0, 0.9, 0.5};
          return in.contains("expedient") ? with[causes] : without[causes];
        });
      },
      [&turns](const std::string& turn) { turns.push_back(turn); });
  EXPECT_THAT(turns,
              testing::ElementsAre("expedient 20.0 % better", "cause 6.2 % better",
                                   "rest of it 20.0 % better", HasSubstr("harm that is none"),
                                   "without expedient 16.7 % better"));
  EXPECT_EQ(found.all, 0.5);
  EXPECT_FALSE(all.front().accepted);
}

TEST(Choose, AcceptsNothingThatHarmsOneHalf) {
  std::vector<Group> all = groups({"half"});
  const Ratio found = choose(all, [](const Patch& patch) {
    return patch.empty() ? Ratio{.all = 1.0, .half = {1.0, 1.0}}
                         : Ratio{.all = 0.8, .half = {1.2, 0.5}};
  });
  EXPECT_EQ(found.all, 1.0);
  EXPECT_FALSE(all.front().accepted);
}

}  // namespace
}  // namespace odomd::tools::fitting::fit_trial_test
