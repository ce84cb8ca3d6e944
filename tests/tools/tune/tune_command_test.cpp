// odom tune as it is called, on drives whose best setting is known: a gyro that over-reads by 5 %
// wants the scale 1/1.05.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/tools/scratch.hpp"
#include "tools/config_patch/config_patch.hpp"

namespace odomd::tools::tune_command_test {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::MatchesRegex;
using testing::Not;

class Tune : public testing::Test {
 protected:
  /// A short lap; `over_reads` is the gyro's scale error.
  std::string drive(const std::string& name, const std::string& over_reads, int seed) {
    const std::string folder = scratch_.path(name);
    const Outcome sim = run_shell(
        "odom sim --ideal --duration 8 --standstill 0.2 --fix gyro_scale_error=" + over_reads +
        " --seed " + std::to_string(seed) + " --out " + folder);
    EXPECT_EQ(sim.status, 0) << sim.err;
    return folder;
  }

  const Scratch scratch_;
  const std::string gyro_ = "--set can.signals.yaw_rate.scale=0.9:1.1 ";
  const std::string how_ = "--no-camera --model paper --goal heading ";
};

TEST_F(Tune, FindsTheScaleOfAGyroThatOverReadsAndWritesIt) {
  const std::string one = drive("one", "0.05", 1);
  const std::string other = drive("other", "0.05", 2);
  const std::string config = one + "/car.toml";
  const Outcome tuned = run_shell("odom tune --drive " + one + " --held-out " + other + " " +
                                  gyro_ + how_ + "--json --write " + config);
  ASSERT_EQ(tuned.status, 0) << tuned.err;
  const json result = json::parse(tuned.out);
  EXPECT_NEAR(result["keys"][0]["after"].get<double>(), 1.0 / 1.05, 0.01);
  EXPECT_TRUE(result["better"].get<bool>());
  EXPECT_LT(result["relative_error"].get<double>(), 0.2);
  EXPECT_LT(result["held_out_relative_error"].get<double>(), 0.2);
  EXPECT_THAT(contents(config), HasSubstr("odom tune: "));
  EXPECT_THAT(contents(config), HasSubstr("% better on 1 drive"));

  // What was written does as well: nothing is left to find.
  const Outcome again = run_shell("odom tune --drive " + one + " " + gyro_ + how_);
  ASSERT_EQ(again.status, 0) << again.err;
  EXPECT_THAT(again.out, HasSubstr("Nothing better was found."));
}

TEST_F(Tune, PutsBackWhatHarmsTheDrivesHeldOutAndWritesNothing) {
  const std::string one = drive("one", "0.05", 1);
  const std::string other = drive("other", "-0.05", 2);
  const std::string config = one + "/car.toml";
  const std::string before = contents(config);
  const Outcome tuned = run_shell("odom tune --drive " + one + " --held-out " + other + " " +
                                  gyro_ + how_ + "--write " + config);
  ASSERT_EQ(tuned.status, 0) << tuned.err;
  EXPECT_THAT(tuned.out, HasSubstr("over-fitted: value kept"));
  EXPECT_THAT(tuned.out, HasSubstr("keep the present configuration"));
  EXPECT_THAT(tuned.err, HasSubstr("is unchanged"));
  EXPECT_EQ(contents(config), before);
}

TEST_F(Tune, SaysWhatItHasWritten) {
  const std::string one = drive("one", "0.05", 1);
  const std::string config = one + "/car.toml";
  const std::string sweep =
      "odom tune --drive " + one + " --set can.signals.yaw_rate.scale=0.952 " + how_ + "--json ";
  const Outcome tuned = run_shell(sweep + "--write " + config);
  ASSERT_EQ(tuned.status, 0) << tuned.err;
  EXPECT_EQ(tuned.err,
            "odom tune: 1 key written to " + config + ": can.signals.yaw_rate.scale 1 > 0.952\n");
  EXPECT_TRUE(json::accept(tuned.out));
  const Outcome again =
      run_shell("odom tune --drive " + one + " --set can.signals.yaw_rate.scale=0.9524 " + how_ +
                "--json --write " + config);
  EXPECT_THAT(again.err,
              testing::AnyOf(HasSubstr("scale 0.952 > 0.9524"), HasSubstr("is unchanged")));
}

TEST_F(Tune, HonestyIsAGoalWhereTheDrivesDetermineIt) {
  const std::string one = drive("one", "0.05", 1);
  const auto goals = [&](const std::string& how) {
    const Outcome tuned =
        run_shell("odom tune --drive " + one + " --set filter.window=0.25 --json " + how);
    EXPECT_EQ(tuned.status, 0) << tuned.err;
    return json::parse(tuned.out)["goals"];
  };
  EXPECT_EQ(goals(""), json({"position", "heading", "prediction", "nees"}));
  EXPECT_EQ(goals("--no-camera"), json({"position", "heading", "prediction"}));
  EXPECT_EQ(goals("--goal end"), json({"end"}));
}

TEST_F(Tune, WritesWhatIsWorseInAGoalByForceOnly) {
  // The gyro's right scale: the path is ten times better, and its first 35 ms are a little worse.
  const std::string one = drive("one", "0.05", 1);
  const std::string config = one + "/car.toml";
  const std::string before = contents(config);
  const std::string command = "odom tune --drive " + one +
                              " --set can.signals.yaw_rate.scale=0.952 --no-camera "
                              "--model paper --json --write " +
                              config;
  const Outcome refused = run_shell(command);
  ASSERT_EQ(refused.status, 0) << refused.err;
  EXPECT_EQ(json::parse(refused.out)["worse_goals"], json({"prediction"}));
  EXPECT_FALSE(json::parse(refused.out)["better"].get<bool>());
  EXPECT_THAT(refused.err, HasSubstr("is unchanged; --force writes it nevertheless"));
  EXPECT_EQ(contents(config), before);

  EXPECT_THAT(run_shell(command + " --force").err, HasSubstr("1 key written"));
  EXPECT_THAT(contents(config), HasSubstr("but worse in prediction"));
}

TEST_F(Tune, ASearchTakesWhatIsWorseInAGoalByForceOnly) {
  const std::string one = drive("one", "0.05", 1);
  const auto searched = [&](const std::string& how) {
    const Outcome tuned = run_shell("odom tune --drive " + one + " " + gyro_ +
                                    "--no-camera --model paper --json " + how);
    EXPECT_EQ(tuned.status, 0) << tuned.err;
    return json::parse(tuned.out);
  };
  const json kept = searched(""), traded = searched("--force");
  EXPECT_EQ(kept["worse_goals"], json::array());
  EXPECT_EQ(traded["worse_goals"], json({"prediction"}));
  EXPECT_LT(traded["relative_error"].get<double>(), kept["relative_error"].get<double>());
}

TEST_F(Tune, WarnsOfAnotherConfigurationThanTheOneThatIsWritten) {
  const std::string one = drive("one", "0.05", 1);
  const std::string sweep =
      "odom tune --drive " + one + " --set can.signals.yaw_rate.scale=0.9,0.952 " + how_;
  const std::string master = scratch_.path("car.toml").string();
  ASSERT_EQ(run_shell("cp " + one + "/car.toml " + master).status, 0);
  EXPECT_THAT(run_shell(sweep + "--write " + master).err,
              testing::Not(HasSubstr("warning")));  // but for the key that it tunes, it is the same

  ASSERT_EQ(run_shell("sed -i 's/^rear_axle = .*/rear_axle = 0.09/' " + master).status, 0);
  EXPECT_THAT(run_shell(sweep + "--write " + master).err,
              HasSubstr("warning: the search runs with " + one + "/car.toml, which differs from " +
                        master + ": vehicle.rear_axle (0.085, 0.09); the result may not suit it"));
  EXPECT_THAT(run_shell(sweep + "--config " + master + " --write " + master).err,
              testing::Not(HasSubstr("warning")));
}

TEST_F(Tune, WarnsOfACameraOfAnotherDriveAndOfTimesThatAreOff) {
  const std::string one = scratch_.path("one"), other = scratch_.path("other");
  const std::string sim = "odom sim --start-time 100 --duration 20 --standstill 1 --out ";
  ASSERT_EQ(run_shell(sim + one).status, 0);
  ASSERT_EQ(run_shell(sim + other + " --scenario slalom").status, 0);
  const std::string sweep = "odom tune --set filter.wheel_slip=0.02 --drive " + one;
  EXPECT_THAT(run_shell(sweep).err,
              Not(HasSubstr("warning")));  // a slow machine says how far it is
  ASSERT_EQ(run_shell("awk -F, -v OFS=, 'NR > 1 {$1 = sprintf(\"%.9f\", $1 + 0.08)} 1' " + one +
                      "/truth.csv > " + one + "/late && mv " + one + "/late " + one + "/truth.csv")
                .status,
            0);
  EXPECT_THAT(run_shell(sweep).err, HasSubstr("odom tune: warning: " + one + ": " + one +
                                              "/truth.csv: its times look 80 ms late against"));
  ASSERT_EQ(run_shell("cp " + other + "/camera.csv " + one).status, 0);
  EXPECT_THAT(run_shell(sweep).err,
              HasSubstr("odom tune: warning: " + one + ": camera: contradicts the other sensors"));
}

TEST_F(Tune, AsksWhetherAReferenceOrACameraIsInMillimetres) {
  const std::string one = scratch_.path("one");
  ASSERT_EQ(run_shell("odom sim --start-time 100 --duration 20 --standstill 1 --out " + one).status,
            0);
  const std::string sweep = "odom tune --set filter.wheel_slip=0.02 --drive " + one;
  const auto in_millimetres = [&](const std::string& file, const std::string& x) {
    ASSERT_EQ(
        run_shell("awk -F, -v OFS=, 'NR > 1 {$" + x + " *= 1000; $(" + x + " + 1) *= 1000} 1' " +
                  one + "/" + file + " > " + one + "/mm && mv " + one + "/mm " + one + "/" + file)
            .status,
        0);
  };
  in_millimetres("camera.csv", "3");
  const std::string camera = run_shell(sweep).err;
  EXPECT_THAT(camera, HasSubstr(": camera: x and y go about 1000 times as far"));
  EXPECT_THAT(camera, testing::Not(HasSubstr("initial pose")));
  in_millimetres("truth.csv", "2");
  EXPECT_THAT(run_shell(sweep + " --no-camera").err,
              HasSubstr(one + "/truth.csv: x and y go about 1000 times as far as the estimate"));
}

TEST_F(Tune, TheSameWhateverTheThreadsAndHoweverOftenItWasStopped) {
  const std::string one = drive("one", "0.05", 1);
  const std::string state = scratch_.path("tune.state");
  const std::string command = "odom tune --drive " + one + " " + gyro_ +
                              "--set vehicle.rear_axle=0.06:0.12 " + how_ + "--json ";
  const Outcome at_once = run_shell(command + "--jobs 1");
  ASSERT_EQ(at_once.status, 0) << at_once.err;
  EXPECT_EQ(run_shell(command + "--jobs 3").out, at_once.out);

  ASSERT_EQ(run_shell(command + "--trials 12 --state " + state).status, 0);
  const std::string whole = contents(state);
  scratch_.write("tune.state", whole.substr(0, whole.size() - 20));  // as a power cut leaves it
  EXPECT_EQ(run_shell(command + "--state " + state).out, at_once.out);
}

TEST_F(Tune, AnInterruptLeavesAStateToGoOnFrom) {
  const std::string one = drive("one", "0.05", 1);
  const std::string state = scratch_.path("tune.state");
  const Outcome stopped =
      run_shell("odom tune --drive " + one + " --set can.signals.yaw_rate.scale=0.9:1.1:1000 " +
                how_ + "--jobs 2 --state " + state + " & pid=$!; until [ $(wc -l <" + state +
                ") -gt 3 ]; do sleep 0.05; done; kill -INT $pid; wait $pid");
  EXPECT_EQ(stopped.status, 1);
  EXPECT_THAT(stopped.err, HasSubstr("the same command continues from here with " + state));
  const std::string text = contents(state);
  EXPECT_EQ(text.back(), '\n');
}

TEST_F(Tune, SweepsEveryCombination) {
  const std::string one = drive("one", "0.05", 1);
  const std::string table = scratch_.path("sweep.csv");
  const Outcome swept = run_shell("odom tune --drive " + one +
                                  " --set can.signals.yaw_rate.scale=0.9,0.95,1 "
                                  "--set vehicle.rear_axle=0.08:0.1:2 " +
                                  how_ + "--json --out " + table);
  ASSERT_EQ(swept.status, 0) << swept.err;
  const json result = json::parse(swept.out);
  EXPECT_EQ(result["trials"].size(), 6U);
  EXPECT_EQ(result["keys"][0]["after"].get<double>(), 0.95);
  EXPECT_THAT(contents(table),
              testing::StartsWith("can.signals.yaw_rate.scale,vehicle.rear_axle,relative_error\n"));
}

TEST_F(Tune, JudgesADriveWithACameraInTheMapAsItIs) {
  const std::string one = drive("one", "0.05", 1);
  const std::string sweep = "--set filter.window=0.25 --goal position,nees --json ";
  const auto rms = [&](const std::string& how) {
    const Outcome tuned = run_shell("odom tune --drive " + one + " " + sweep + how);
    EXPECT_EQ(tuned.status, 0) << tuned.err;
    return json::parse(tuned.out)["drives"][0]["position"]["before"].get<double>();
  };
  EXPECT_EQ(rms(""), rms("--align none"));
  const Outcome evaluated = run_shell("odom evaluate --drive " + one + " --model full --json");
  ASSERT_EQ(evaluated.status, 0) << evaluated.err;
  EXPECT_EQ(rms(""), json::parse(evaluated.out)["summary"][0]["position_rms"].get<double>());
}

TEST_F(Tune, SaysThatTheSearchWasCutShort) {
  const std::string one = drive("one", "0.05", 1);
  const std::string command = "odom tune --drive " + one + " " + gyro_ + how_;
  EXPECT_THAT(run_shell(command + "--trials 4").out, HasSubstr("cut short by --trials 4"));
  EXPECT_THAT(run_shell(command).out, testing::Not(HasSubstr("cut short")));
}

TEST_F(Tune, ReportsBeforeTheWorkWhatCannotBeWritten) {
  const std::string one = drive("one", "0.05", 1);
  const std::string state = scratch_.path("tune.state");
  const std::string command =
      "odom tune --drive " + one + " " + gyro_ + how_ + "--state " + state + " ";
  const std::string nowhere = scratch_.path("none").string();
  for (const std::string& what : {"--write " + nowhere + ".toml", "--out " + nowhere + "/a.csv"}) {
    const Outcome refused = run_shell(command + what);
    EXPECT_EQ(refused.status, 2) << what;
    EXPECT_EQ(refused.out, "") << what;
    EXPECT_THAT(refused.err, HasSubstr(nowhere)) << what;
    EXPECT_FALSE(std::filesystem::exists(state)) << what;
  }
}

TEST_F(Tune, SaysWhatIsWrongWithAKeyADriveOrARange) {
  const std::string one = drive("one", "0", 1);
  const auto refused = [&](const std::string& arguments) {
    const Outcome outcome = run_shell("odom tune " + arguments);
    EXPECT_EQ(outcome.status, 2) << arguments;
    EXPECT_EQ(outcome.out, "") << arguments;
    return outcome.err;
  };
  EXPECT_THAT(
      refused("--drive " + one + " --set filter.wheel_slipp=0.01,1"),
      MatchesRegex("odom tune: --set filter.wheel_slipp=(0.01|1): \\[filter\\] wheel_slipp: "
                   "unknown key; did you mean \"wheel_slip\"\\? \\(.*/one/car.toml\\)\n"));
  EXPECT_THAT(refused("--drive " + one + " --set filter.wheel_slip=0.01,0.02 --set imu.yaw=9,8"),
              HasSubstr("--set imu.yaw=8: [imu] yaw: 8 is not possible; it must be "));
  EXPECT_THAT(refused("--drive " + one + " --set can.dbc=0.01:1"),
              MatchesRegex("odom tune: .*/one/car.toml:[0-9]+: \\[can\\] dbc: is not a number; "
                           "correct it, or give another key\n"));
  EXPECT_THAT(refused("--drive " + one +
                      " --set filter.wheel_slip=0.01"
                      " --set filter.window=0.2:0.4"),
              HasSubstr("ranges for all or values for all"));
  EXPECT_THAT(refused("--drive " + one + " --held-out " + one + " --set filter.window=0.2:0.4"),
              HasSubstr("is also given with --drive"));
  EXPECT_THAT(
      refused("--drive " + one + " --held-out " + one + "/../one" + " --set filter.window=0.2:0.4"),
      HasSubstr("is also given with --drive"));
  EXPECT_THAT(refused("--drive " + one + " --no-camera --goal nees --set filter.window=0.2:0.4"),
              HasSubstr("--goal nees: none of the drives tuned on determines it: "));
  EXPECT_THAT(refused("--drive " + one + " --lever-arm nan,0,0 --set filter.window=0.2:0.4"),
              HasSubstr("--lever-arm: must be three finite numbers"));
  EXPECT_THAT(refused("--drive " + scratch_.path("none").string() + " --set filter.window=0.2:0.4"),
              HasSubstr("is not a folder"));
  EXPECT_THAT(refused("--drive " + one + " --goal speed --set filter.window=0.2:0.4"),
              HasSubstr("is none of position"));
  // Before the search, not after it.
  const std::string state = scratch_.path("no.state").string();
  const std::string turned =
      "--drive " + one + " --set filter.window=0.2:0.4 --state " + state + " ";
  EXPECT_THAT(refused(turned + "--out /nonexistent/t.csv"), HasSubstr("no folder /nonexistent"));
  EXPECT_THAT(refused(turned + "--write " + one + "/none.toml"),
              HasSubstr("none.toml: there is no such file"));
  const std::string truth = one + "/truth.csv";
  for (const std::string option : {"--out", "--state"})
    EXPECT_THAT(refused("--drive " + one + " --set filter.window=0.2:0.4 " + option + " " + truth),
                HasSubstr(option + ": " + truth + " is what is read; name another file"));
  EXPECT_EQ(contents(state), "");
  ASSERT_EQ(run_shell("rm " + one + "/truth.csv").status, 0);
  const std::string narrow = "--drive " + one + " --set filter.window=0.2:0.4";
  EXPECT_THAT(refused(narrow + " --goal prediction"),
              HasSubstr("--goal prediction: none of the drives tuned on determines it"));
  EXPECT_THAT(refused(narrow + " --lever-arm 0,0,0"), HasSubstr("--lever-arm is of a truth.csv"));
  ASSERT_EQ(run_shell("rm " + one + "/camera.csv").status, 0);
  EXPECT_THAT(refused(narrow + " --goal position"),
              HasSubstr("they have neither truth.csv nor camera.csv"));
  EXPECT_THAT(refused(narrow + " --model paper"),
              HasSubstr("none of the drives tuned on determines a goal of the search"));
}

TEST_F(Tune, FindsTheScaleOfAGyroByTheCameraAlone) {
  const std::string one = drive("one", "0.05", 1);
  ASSERT_EQ(run_shell("rm " + one + "/truth.csv").status, 0);
  const Outcome tuned = run_shell("odom tune --drive " + one + " " + gyro_ + how_ + "--json");
  ASSERT_EQ(tuned.status, 0) << tuned.err;
  EXPECT_THAT(tuned.err, HasSubstr(one + ": reference camera.csv"));
  const json result = json::parse(tuned.out);
  EXPECT_NEAR(result["keys"][0]["after"].get<double>(), 1.0 / 1.05, 0.01);
  EXPECT_EQ(result["goals"], json::array({"heading"}));
}

TEST_F(Tune, TakesTheInnovationsWhereNothingElseIsKnown) {
  const std::string one = drive("one", "0", 1);
  ASSERT_EQ(run_shell("rm " + one + "/truth.csv " + one + "/camera.csv").status, 0);
  const Outcome tuned =
      run_shell("odom tune --drive " + one + " --set filter.window=0.3,0.4 --json");
  ASSERT_EQ(tuned.status, 0) << tuned.err;
  EXPECT_EQ(json::parse(tuned.out)["goals"], json::array({"nis"}));
}

}  // namespace
}  // namespace odomd::tools::tune_command_test
