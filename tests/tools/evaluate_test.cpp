// odom evaluate, as it is called.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "tests/tools/drives.hpp"
#include "tests/tools/scratch.hpp"

namespace odomd::tools {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

class Evaluate : public ::testing::Test {
 protected:
  void SetUp() override {
    reference_ = scratch_.write("ref.csv", csv_of(wavy_drive(0.0, 5.0, 0.01))).string();
    good_ = scratch_.write("good.csv", csv_of(wavy_drive(0.0, 4.0, 0.005))).string();
    Trajectory drift = wavy_drive(0.0, 4.0, 0.005);
    for (auto& point : drift.points) point.pose.x *= 1.02;
    drift_ = scratch_.write("drift.csv", csv_of(drift)).string();
  }
  static Outcome run(const std::string& arguments) {
    return run_shell("odom evaluate " + arguments);
  }
  void expect_refused(const std::string& pose_text, const std::string& what) const {
    const auto file = scratch_.write("bad.csv", pose_text).string();
    const Outcome outcome = run("--reference " + reference_ + " --pose " + file);
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    EXPECT_THAT(outcome.err, StartsWith("odom evaluate: " + file));
    EXPECT_THAT(outcome.err, HasSubstr(what));
    EXPECT_EQ(outcome.err.find('\n'), outcome.err.size() - 1);
  }

  Scratch scratch_;
  std::string reference_, good_, drift_;
};

TEST_F(Evaluate, WritesATableWithAColumnAPoseFile) {
  const Outcome outcome =
      run("--reference " + reference_ + " --pose " + drift_ + " --pose " + good_);
  EXPECT_EQ(outcome.status, 0);
  EXPECT_EQ(outcome.err, "");
  EXPECT_THAT(outcome.out, HasSubstr("drift"));
  EXPECT_THAT(outcome.out, HasSubstr("end error [cm/m]"));
  EXPECT_THAT(outcome.out, HasSubstr("end error better by [%]"));
}

TEST_F(Evaluate, WritesJsonInTheOrderOfTheFiles) {
  const Outcome outcome =
      run("--json --reference " + reference_ + " --pose " + drift_ + " --pose " + good_);
  const auto json = nlohmann::json::parse(outcome.out);
  ASSERT_EQ(json["estimates"].size(), 2U);
  EXPECT_EQ(json["estimates"][0]["pose"], drift_);
  EXPECT_EQ(json["estimates"][0]["samples"], 801);
  EXPECT_GT(json["estimates"][0]["end_error"], json["estimates"][1]["end_error"]);
  EXPECT_GT(json["estimates"][1]["improvement_percent"]["end_error"], 99.0);
  EXPECT_TRUE(json["estimates"][1]["nees"].is_null());
}

TEST_F(Evaluate, TakesALeverArmOrFitsOneAndSaysSo) {
  EXPECT_THAT(
      run("--reference " + reference_ + " --pose " + good_ + " --lever-arm -0.1,0,0").out,
      HasSubstr("lever arm  -0.1000 m, 0.0000 m, 0.00 deg of the reference point, as given"));
  EXPECT_THAT(run("--reference " + reference_ + " --pose " + good_ + " --fit-lever-arm").out,
              HasSubstr("fitted to"));
  EXPECT_EQ(run("--reference " + reference_ + " --pose " + good_ + " --lever-arm 1,2").status, 2);
  EXPECT_EQ(run("--reference " + reference_ + " --pose " + good_ + " --lever-arm 1,nan,2").status,
            2);
}

TEST_F(Evaluate, DrawsAPicture) {
  const auto svg = scratch_.path("lap.svg");
  EXPECT_EQ(
      run("--reference " + reference_ + " --pose " + good_ + " --picture " + svg.string()).status,
      0);
  EXPECT_THAT(contents(svg), StartsWith("<svg"));
}

TEST_F(Evaluate, RefusesBadFilesInOneLine) {
  expect_refused("t,x,y\n0,0,0\n", R"(:1: no column "yaw")");
  expect_refused("t,x,y,yaw\n0,0,nan,0\n", R"(:2: column "y": "nan" is not a finite number)");
  expect_refused("t,x,y,yaw\n1,0,0,0\n0.5,0,0,0\n", ":3: column \"t\": the time runs backwards");
  expect_refused("t,x,y,yaw\n1,0\n2,0,0,0\n", ":2: 2 fields where the header has 4");
  expect_refused("", ": is empty");
  expect_refused("t,x,y,yaw\n", ": has no rows");
  expect_refused("t,x,y,yaw\n100,0,0,0\n101,0,0,0\n", "less than two common times");
}

TEST_F(Evaluate, KeepsADriveWhoseLastLineIsCutOff) {
  const std::string whole = contents(good_);
  const auto cut = scratch_.write("cut.csv", whole.substr(0, whole.size() - 40)).string();
  const Outcome outcome = run("--reference " + reference_ + " --pose " + cut);
  EXPECT_EQ(outcome.status, 0);
  EXPECT_THAT(outcome.err, HasSubstr("warning: " + cut + ":802: the last line is cut off"));
}

TEST_F(Evaluate, WrongUsageIsStatusTwoWithTheMend) {
  EXPECT_EQ(run("").status, 2);
  EXPECT_THAT(run("").err, HasSubstr("--reference is required; see odom evaluate --help"));
  const Outcome missing = run("--reference /nonexistent.csv --pose " + good_);
  EXPECT_EQ(missing.status, 2);
  EXPECT_EQ(missing.err,
            "odom evaluate: /nonexistent.csv: no such file or directory; check the path\n");
  const Outcome last = run("--reference " + reference_ + " --pose " + good_ + " --align last");
  EXPECT_EQ(last.status, 2);
  EXPECT_THAT(last.err, HasSubstr("--align: \"last\" is none of first|fit|none"));
  EXPECT_EQ(run("--reference " + reference_ + " --pose /").status, 2);
}

TEST_F(Evaluate, AlignsAsItIsTold) {
  const auto aligned = [&](const std::string& how) {
    return nlohmann::json::parse(
        run("--json --reference " + reference_ + " --pose " + drift_ + how).out)["align"];
  };
  EXPECT_EQ(aligned(""), "first");
  for (const std::string how : {"first", "fit", "none"}) EXPECT_EQ(aligned(" --align " + how), how);
}

TEST_F(Evaluate, HelpIsText) {
  const std::string help = run("--help").out;
  EXPECT_THAT(help, HasSubstr("--align first|fit|none"));
  for (const char c : help) EXPECT_TRUE(c == '\n' || static_cast<unsigned char>(c) >= 0x20);
}

TEST_F(Evaluate, HelpHasExamples) {
  const Outcome outcome = run("--help");
  EXPECT_EQ(outcome.status, 0);
  EXPECT_THAT(outcome.out, HasSubstr("odom evaluate --reference truth.csv --pose pose.csv"));
}

}  // namespace
}  // namespace odomd::tools
