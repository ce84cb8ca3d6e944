// Evaluation of drives from their files, and their score.
#include <limits>

#include "estimator/common/pose.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/evaluation/drive_evaluation.hpp"
#include "tools/evaluation/evaluated_drive.hpp"

namespace odomd::tools::drive_evaluation_test {
namespace {

// One short simulated lap for all tests.
class DriveEvaluation : public ::testing::Test {
 protected:
  static const SharedDrive& shared() {
    static const SharedDrive made{"--scenario lap --duration 4 --standstill 0.5 --seed 3", "lap"};
    return made;
  }
  static std::filesystem::path lap() { return shared().folder; }
};

Evaluation evaluated(const Drive& drive,
                     const std::optional<estimator::Pose2>& lever_arm = std::nullopt) {
  return evaluate(reference_of(drive, lever_arm), replay_drive(drive, drive.config).poses,
                  usual_align(!drive.cameras.empty(), Frame::map));
}

TEST_F(DriveEvaluation, KeepsEveryJudgementWithItsTimeAndVariance) {
  const Drive drive = read_drive({.folder = lap()});
  EXPECT_TRUE(replay_drive(drive, drive.config).judgements.empty());
  const ReplayedDrive replayed = replay_drive(drive, drive.config, Frame::map, Judgements::keep);
  std::array<std::size_t, estimator::source_count> tested{};
  for (const estimator::Judgement& judgement : replayed.judgements) {
    EXPECT_GE(judgement.time_ns, replayed.summary.first_tick_ns - 1'000'000'000);
    EXPECT_LE(judgement.time_ns, replayed.summary.last_tick_ns);
    if (judgement.degrees == 1) {
      EXPECT_NEAR(judgement.innovation[0] * judgement.innovation[0] / judgement.variance[0],
                  judgement.squared_ratio, 1e-9 * (1.0 + judgement.squared_ratio));
    }
    if (judgement.degrees == 3 && judgement.squared_ratio > 0.0) {
      for (const double variance : judgement.variance) EXPECT_GT(variance, 0.0);
    }
    if (judgement.degrees > 0) ++tested[static_cast<std::size_t>(judgement.source)];
  }
  for (std::size_t source = 0; source < tested.size(); ++source) {
    EXPECT_EQ(tested[source], replayed.summary.innovations[source].count)
        << estimator::source_names[source];
  }
  constexpr auto camera = static_cast<std::size_t>(estimator::Source::camera);
  EXPECT_GT(tested[camera], 80U);
  EXPECT_EQ(
      replayed.summary.verdicts[camera][static_cast<std::size_t>(estimator::Verdict::fused)] +
          replayed.summary.innovations[camera].gated,
      replayed.summary.cameras -
          replayed.summary.verdicts[camera][static_cast<std::size_t>(estimator::Verdict::too_old)]);
}

// A database that is not next to the configuration is taken from the drive's folder.
TEST_F(DriveEvaluation, UsesAnotherConfigurationWithItsDatabaseAndReference) {
  const Scratch& scratch = shared().scratch;
  const std::string text = contents(lap() / "car.toml") + "\n[filter]\nmodel = \"kinematic\"\n";
  const auto read = [](const std::filesystem::path& config) {
    return read_drive({.folder = lap(), .config = config, .reference = lap() / "truth.csv"});
  };
  const Drive drive = read(scratch.write("other.toml", text));
  EXPECT_EQ(drive.config.model, estimator::Model::kinematic);
  EXPECT_EQ(drive.config.can.dbc.front(), std::filesystem::absolute(lap() / "car.dbc"));
  EXPECT_GT(evaluated(drive).samples, 500U);
  std::filesystem::create_directory(scratch.path("with"));
  const auto with = scratch.write("with/car.dbc", contents(lap() / "car.dbc"));
  EXPECT_EQ(read(scratch.write("with/car.toml", text)).config.can.dbc.front(), with);
  const auto nowhere = scratch.write("other_name.toml",
                                     std::string(text).replace(text.find("car.dbc"), 7, "no.dbc"));
  EXPECT_THAT(message_of([&] { (void)read(nowhere); }), HasSubstr("no.dbc"));
}

TEST_F(DriveEvaluation, ConvertsTheTruthToTheCentreOfGravityWithItsLeverArm) {
  const Drive drive = read_drive({.folder = lap(), .camera = CameraUse::leave_out});
  ASSERT_TRUE(drive.config.reference_lever_arm);  // 0 in drives of odom sim
  const double expected = evaluated(drive).position.rms;

  const estimator::Pose2 arm{0.1, -0.05, 0.2};
  Drive armed = drive;
  for (TrajectoryPoint& point : armed.reference->points)
    point.pose = estimator::compose(point.pose, arm);
  EXPECT_GT(evaluated(armed).position.rms, expected + 0.05);
  EXPECT_NEAR(evaluated(armed, arm).position.rms, expected, 1e-9);
  armed.config.reference_lever_arm = {arm.x, arm.y, arm.yaw};
  EXPECT_NEAR(evaluated(armed).position.rms, expected, 1e-9);
  armed.config.reference_lever_arm.reset();
  armed.config.camera.lever_arm = {arm.x, arm.y, arm.yaw};
  EXPECT_NEAR(evaluated(armed).position.rms, expected, 1e-9);
}

TEST_F(DriveEvaluation, ReportHasTheLeverArmOfTheConfiguration) {
  const auto arm_of = [](const std::filesystem::path& config, const Judging& judging) {
    const DriveFiles files{.folder = lap(), .config = config, .camera = CameraUse::leave_out};
    return evaluate_folder(files, {estimator::Model::inertial}, judging).report.lever_arm;
  };
  EXPECT_FALSE(arm_of({}, {}));
  std::string text = contents(lap() / "car.toml");
  const std::string of_sim = "[reference]\nlever_arm = [0.0, 0.0, 0.0]\n";
  const std::size_t at = text.find(of_sim);
  ASSERT_NE(at, std::string::npos);
  text.replace(at, of_sim.size(), "[reference]\nlever_arm = [0.1, -0.05, 0.2]\n");
  const auto config = shared().scratch.write("armed.toml", text);
  EXPECT_EQ(arm_of(config, {}).value_or(estimator::Pose2{}).y, -0.05);
  EXPECT_EQ(arm_of(config, {.lever_arm = estimator::Pose2{}}).value_or(estimator::Pose2{1.0}).x,
            0.0);
}

TEST_F(DriveEvaluation, SaysInOneLineWhatIsMissingInAFolder) {
  const auto folder = shared().scratch.path("bare");
  std::filesystem::create_directory(folder);
  const auto refusal = [&folder] {
    return message_of([&] {
      const Drive drive = read_drive({.folder = folder});
      (void)replay_drive(drive, drive.config);
    });
  };
  EXPECT_THAT(message_of([] { (void)read_drive({.folder = "/nonexistent"}); }),
              HasSubstr("/nonexistent: is not a folder"));
  EXPECT_THAT(refusal(), HasSubstr("has no car.toml; give the car's configuration with --config"));
  for (const char* file : {"car.toml", "car.dbc"})
    std::filesystem::copy(lap() / file, folder / file);
  EXPECT_THAT(refusal(), StartsWith(folder.string() + ": has no drive.log and no can.log"));
  std::filesystem::copy(lap() / "drive.log", folder / "drive.log");
  const Drive blind = read_drive({.folder = folder});
  EXPECT_FALSE(blind.reference);
  EXPECT_FALSE(replay_drive(blind, blind.config).poses.points.empty());
  std::ofstream{folder / "drive.log"} << "(1.000000) can0 123#00\n";
  const Drive silent = read_drive({.folder = folder});
  EXPECT_THAT(
      message_of([&] { (void)replay_drive(silent, silent.config); }),
      StartsWith(folder.string() + ": none of the 4 mapped messages is among the 1 frames"));
  // The frame is mapped, but it has no wheel speed.
  std::ofstream{folder / "drive.log"} << "(1.000000) can0 1A2#0000000000000000\n";
  const Drive still = read_drive({.folder = folder});
  EXPECT_THAT(message_of([&] { (void)replay_drive(still, still.config); }),
              StartsWith(folder.string() + ": no pose: "));
}

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

Score score(double position, double heading) {
  return {unknown, unknown, position, heading};
}

TEST(Score, IsTheGeometricMeanOfTheRatios) {
  const std::array before{score(1.0, 0.1), score(100.0, 0.1)};
  const std::array tried{score(0.5, 0.1), score(100.0, 0.2)};
  EXPECT_NEAR(relative_error(tried, before), 1.0, 1e-12);  // half in one measure, twice in another
  const std::array better{score(0.5, 0.05), score(50.0, 0.05)};
  EXPECT_NEAR(relative_error(better, before), 0.5, 1e-12);
}

TEST(Score, UnknownBeforeDoesNotCountAndUnknownAfterwardsIsInfinitelyBad) {
  const std::vector<Score> before{score(1.0, unknown)};
  EXPECT_NEAR(relative_error(std::vector{score(0.7, 3.0)}, before), 0.7, 1e-12);
  EXPECT_TRUE(std::isinf(relative_error(std::vector{score(unknown, 3.0)}, before)));
}

TEST(Score, IsMadeOfTheEvaluation) {
  Evaluation evaluation;
  evaluation.position.rms = 0.3;
  evaluation.heading.rms = 0.02;
  evaluation.horizons = {{.horizon_ns = 5'000'000, .displacement = {.mean = 1e-4}},
                         {.horizon_ns = 1'000'000'000, .displacement = {.mean = 5e-3}}};
  EXPECT_TRUE(std::isnan(score_of(evaluation)[0]));
  evaluation.horizons.push_back({.horizon_ns = 35'000'000, .displacement = {.mean = 4e-4}});
  EXPECT_EQ(score_of(evaluation), (Score{4e-4, 5e-3, 0.3, 0.02}));
}

}  // namespace
}  // namespace odomd::tools::drive_evaluation_test
