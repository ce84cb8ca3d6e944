// odom evaluate as a command.
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/tools/drives.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/cli/csv.hpp"

namespace odomd::tools::evaluate_test {
namespace {

class Evaluate : public ::testing::Test {
 protected:
  void SetUp() override {
    reference_ = scratch_.write("ref.csv", csv_of(wavy_drive(0.0, 4.2, 0.01))).string();
    good_ = scratch_.write("good.csv", csv_of(wavy_drive(0.0, 4.0, 0.005))).string();
    Trajectory drift = wavy_drive(0.0, 4.0, 0.005);
    for (auto& point : drift.points) point.pose.x *= 1.02;
    drift_ = scratch_.write("drift.csv", csv_of(drift)).string();
  }
  static Outcome run(const std::string& arguments) {
    return run_shell("odom evaluate " + arguments);
  }
  [[nodiscard]] std::string both() const { return "--reference " + reference_ + " --pose "; }
  static void refuses(
      const std::vector<std::pair<std::string, ::testing::Matcher<std::string>>>& lines) {
    expect_refused("odom evaluate ", lines);
  }

  Scratch scratch_;
  std::string reference_, good_, drift_;
};

TEST_F(Evaluate, WritesATableWithAColumnAPoseFileAndAPicture) {
  const std::string svg = scratch_.path("lap.svg").string();
  const Outcome outcome = run(both() + drift_ + " --pose " + good_ + " --picture " + svg);
  EXPECT_THAT(outcome, Ends(0, ""));
  // Three rows of short horizons; the others are only in JSON.
  for (const char* part :
       {"drift", "end error [cm/m]", "end error better by [%]", "35 ms error mean [mm]",
        "35 ms yaw error mean [deg]", "1000 ms error mean"})
    EXPECT_THAT(outcome.out, HasSubstr(part));
  EXPECT_THAT(outcome.out, Not(ContainsRegex("35 ms.* max|\n100 ms|\n5 ms")));
  EXPECT_THAT(contents(svg), StartsWith("<svg"));
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
      run(both() + good_ + " --lever-arm -0.1,0,0").out,
      HasSubstr("lever arm  -0.1000 m, 0.0000 m, 0.00 deg of the reference point, as given"));
  EXPECT_THAT(run(both() + good_ + " --fit-lever-arm").out, HasSubstr("fitted to"));
}

TEST_F(Evaluate, KeepsWhatItReads) {
  const std::string drive = simulate(scratch_, "--ideal --duration 1");
  for (const std::string file : {"car.toml", "car.dbc", "drive.log", "camera.csv", "truth.csv"}) {
    const std::string text = contents(drive + "/" + file);
    EXPECT_THAT(run("--drive " + drive + " --html " + drive + "/../drive/" + file).err,
                HasSubstr("is what is read"))
        << file;
    EXPECT_EQ(contents(drive + "/" + file), text);
  }
}

TEST_F(Evaluate, SaysWhyAReportCannotBeWritten) {
  EXPECT_THAT(run(both() + good_ + " --html /dev/full"),
              Ends(1, "odom evaluate: /dev/full: cannot be written: No space left on device\n"));
}

TEST_F(Evaluate, RefusesBadFilesInOneLine) {
  for (const auto& [text, what] : std::vector<std::pair<const char*, const char*>>{
           {"t,x,y,yaw\n0,0,nan,0\n", R"(:2: column "y": "nan" is not a finite number)"},
           {"t,x,y,yaw\n100,0,0,0\n101,0,0,0\n", "fewer than two common times"},
           {"t,x,y,yaw\n9223372036.8,0,0,0\n",
            R"(:2: column "t": "9223372036.8" is not a time in seconds)"}}) {
    const std::string bad = scratch_.write("bad.csv", text).string();
    refuses({{both() + bad, AllOf(StartsWith("odom evaluate: " + bad), HasSubstr(what))}});
  }
}

TEST_F(Evaluate, KeepsADriveWhoseLastLineIsCutOff) {
  const std::string whole = contents(good_);
  const auto cut = scratch_.write("cut.csv", whole.substr(0, whole.size() - 40)).string();
  EXPECT_THAT(run(both() + cut),
              Ends(0, HasSubstr("warning: " + cut + ":802: the last line is cut off")));
}

TEST_F(Evaluate, SaysWhereTheReferenceEndsEarly) {
  const auto early = scratch_.write("early.csv", csv_of(wavy_drive(0.0, 2.0, 0.01))).string();
  EXPECT_THAT(
      run("--reference " + early + " --pose " + good_),
      Ends(0, "odom evaluate: warning: " + good_ +
                  ": the reference covers 2.0 s of 4.0 s; the rest is not evaluated [W412]\n"));
}

TEST_F(Evaluate, SaysThatAnEstimateIsOfAPartOfTheReference) {
  const auto part = scratch_.write("part.csv", csv_of(wavy_drive(1.0, 2.0, 0.005))).string();
  EXPECT_THAT(
      run(both() + part + " --pose " + good_),
      Ends(0, AllOf(HasSubstr("warning: " + part +
                              ": it covers 1.0 s and 0.8 m of the reference's 4.2 s and 4.2 m; "
                              "all figures are for that part only [W413]\n"),
                    Not(HasSubstr(good_ + ": it covers")))));
  // No warning for a requested part, unless the file covers less.
  EXPECT_EQ(run(both() + good_ + " --from +1 --to +2").err, "");
  EXPECT_THAT(run(both() + part + " --from +0.5 --to +3").err,
              HasSubstr(part + ": it covers 1.0 s"));
}

// A drive's file with its first columns shifted by these seconds.
std::string later(const std::string& file, std::size_t columns, double seconds) {
  std::istringstream text(contents(file));
  std::string line, moved;
  std::getline(text, line);
  moved = line + '\n';
  while (std::getline(text, line)) {
    for (std::size_t i = 0; i < columns; ++i) {
      const std::size_t comma = line.find(',');
      append_seconds(
          moved, *parse_seconds(line.substr(0, comma)) + static_cast<std::int64_t>(seconds * 1e9));
      moved += ',';
      line.erase(0, comma + 1);
    }
    moved += line + '\n';
  }
  return moved;
}

TEST_F(Evaluate, SaysThatTheTimesOfTheReferenceAreOffInThePartThatIsEvaluated) {
  Trajectory reference = wavy_drive(0.0, 40.0, 0.01);
  for (auto& point : reference.points)
    if (point.t_ns > 20'000'000'000) point.t_ns += 60'000'000;
  const auto late = scratch_.write("late.csv", csv_of(reference)).string();
  const auto pose = scratch_.write("pose.csv", csv_of(wavy_drive(0.0, 40.0, 0.005))).string();
  const std::string files = "--reference " + late + " --pose " + pose;
  EXPECT_EQ(run(files + " --to +20").err, "");
  EXPECT_THAT(run(files + " --from +21"),
              Ends(0, StartsWith("odom evaluate: warning: " + late +
                                 ": its times look 60 ms late compared with the poses")));
}

TEST_F(Evaluate, SaysWhoseTimesAreOffInADrive) {
  const std::string drive = simulate(scratch_, "--duration 30 --standstill 1", "lap");
  const std::string truth = contents(drive + "/truth.csv");
  const auto warnings = [&](const std::string& how = "") {
    const Outcome outcome = run("--drive " + drive + how);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return outcome.err;
  };
  EXPECT_EQ(warnings(), "");
  EXPECT_EQ(warnings(" --dead-reckoning"), "");

  scratch_.write("lap/truth.csv", later(drive + "/truth.csv", 1, 0.08));
  constexpr auto of_reference = "/truth.csv: its times look 80 ms late against the bus";
  EXPECT_THAT(warnings(), HasSubstr(of_reference));
  EXPECT_THAT(warnings(" --dead-reckoning"), HasSubstr(of_reference));

  const std::string moved = later(drive + "/camera.csv", 2, 0.08);
  scratch_.write("lap/camera.csv", moved);
  EXPECT_THAT(warnings(" --model full"), HasSubstr("/truth.csv, camera.csv: their times look 8"));

  scratch_.write("lap/truth.csv", truth);
  EXPECT_THAT(warnings(),
              HasSubstr("warning: lap: camera.csv: its times look 80 ms late against the bus"));
}

TEST_F(Evaluate, SaysThatTheReferenceIsOfAnotherDrive) {
  Trajectory other = wavy_drive(0.0, 5.0, 0.01);
  for (auto& point : other.points) point.pose.yaw = 0.6 * static_cast<double>(point.t_ns) * 1e-9;
  const auto file = scratch_.write("other.csv", csv_of(other)).string();
  EXPECT_THAT(run(both() + file).err,
              HasSubstr(file + ": its turns disagree with the reference's"));
}

TEST_F(Evaluate, SaysThatReferenceAndPoseLookExchanged) {
  std::string poses = "t,x,y,yaw,sigma_x,sigma_y,sigma_yaw\n";
  for (int i = 0; i < 5; ++i) poses += std::to_string(i) + ",0,0,0,.1,.1,.1\n";
  const auto file = scratch_.write("poses.csv", poses).string();
  constexpr auto warning = "check whether --reference and --pose are exchanged";
  EXPECT_THAT(run("--reference " + file + " --pose " + good_).err, HasSubstr(warning));
  EXPECT_THAT(run("--reference " + good_ + " --pose " + file).err, Not(HasSubstr(warning)));
}

TEST_F(Evaluate, WrongUsageIsStatusTwoWithTheFix) {
  refuses(
      {{"", HasSubstr("--pose or --drive is required; see odom evaluate --help")},
       {"--pose " + good_,
        HasSubstr("--reference (or --closed-loop) is required; see odom evaluate --help")},
       {"--reference /nonexistent.csv --pose " + good_,
        "odom evaluate: /nonexistent.csv: no such file or directory; check the path\n"},
       {both() + good_ + " --align last", HasSubstr("--align: \"last\" is none of first|fit|none")},
       {both() + good_ + " --lever-arm 1,2", HasSubstr("--lever-arm")},
       {both() + good_ + " --lever-arm 1,nan,2", HasSubstr("--lever-arm")},
       {both() + good_ + " --html " + good_,
        "odom evaluate: --html: " + good_ + " is what is read; name another file\n"},
       {both() + good_ + " --html -",
        "odom evaluate: --html: - is the summary too; name another file\n"},
       {both() + "/", HasSubstr("/")}});
}

TEST_F(Evaluate, JudgesAWindowAlignedAtItsBegin) {
  const auto judged = [&](const std::string& window) {
    const Outcome outcome =
        run("--json --reference " + reference_ + " --pose " + drift_ + " " + window);
    EXPECT_EQ(outcome.err, "");
    return nlohmann::json::parse(outcome.out)["estimates"][0];
  };
  const auto relative = judged("--from +1 --to +3");
  EXPECT_EQ(relative["samples"], 401);
  EXPECT_EQ(relative["t_first"], 1.0);
  EXPECT_EQ(relative["t_last"], 3.0);
  EXPECT_NEAR(relative["path_length"], 2.0, 1e-4);
  // x is stretched by 2 %: the error over all four seconds is larger than over two.
  EXPECT_LT(relative["end_error"], judged("")["end_error"]);
  EXPECT_GT(relative["end_error"], 0.0);
  EXPECT_EQ(judged("--from 1 --to 3"), relative);
  EXPECT_EQ(judged("--from 3.5")["samples"], 101);
  EXPECT_EQ(judged("--to 0.5")["samples"], 101);
}

TEST_F(Evaluate, GivesTimesAsTheFilesHaveThem) {
  std::string rows = "t,x,y,yaw\n";
  for (int i = 0; i < 20; ++i)
    rows += "17600000" + std::to_string(10 + i) + ".55," + std::to_string(i) + ",0,0\n";
  const std::string file = scratch_.write("late.csv", rows).string();
  const Outcome outcome = run("--json --reference " + file + " --pose " + file);
  EXPECT_THAT(outcome.out, HasSubstr("\"t_first\": 1760000010.55,"));
  EXPECT_THAT(outcome.out, HasSubstr("\"t_last\": 1760000029.55,"));
}

TEST_F(Evaluate, WarnsOfHeadingsInDegrees) {
  Trajectory degrees = wavy_drive(0.0, 8.0, 0.005);
  for (auto& point : degrees.points) point.pose.yaw *= 180.0 / 3.14159265358979;
  const std::string file = scratch_.write("degrees.csv", csv_of(degrees)).string();
  constexpr auto warning = "the headings do not follow the path";
  EXPECT_THAT(run("--reference " + file + " --pose " + good_).err,
              HasSubstr(file + ": " + warning));
  EXPECT_THAT(run(both() + file).err, HasSubstr(file + ": " + warning));
}

TEST_F(Evaluate, RefusesAWindowWithoutRows) {
  const std::string files = both() + good_;
  EXPECT_THAT(
      run(files + " --from +60"),
      Ends(2, "odom evaluate: " + good_ +
                  ": no row within --from and --to; its times are 0.000000000 to 4.000000000\n"));
  EXPECT_EQ(run(files + " --from 3 --to 2").status, 2);
  EXPECT_THAT(run(files + " --to 0").err, HasSubstr("fewer than two common times"));
  EXPECT_THAT(run(files + " --from -90000").err, HasSubstr("lies more than a day before"));
  for (const std::string bad : {"+", "x", "++1", "1e999", "+9223372036.9"}) {
    EXPECT_THAT(run(std::string{files}.append(" --from ").append(bad)),
                Ends(2, HasSubstr("--from: \"" + bad + "\" is not a time")));
    EXPECT_EQ(run(std::string{files}.append(" --to ").append(bad)).status, 2);
  }
}

TEST_F(Evaluate, JudgesTheOdometryFrame) {
  // A map pose that jumps by a metre on the way; the pose in the odometry frame does not.
  std::string text = "t,x,y,yaw,odom_x,odom_y,odom_yaw,sigma_x,sigma_y,sigma_yaw\n";
  for (const TrajectoryPoint& point : wavy_drive(0.0, 4.0, 0.005).points) {
    const auto& pose = point.pose;
    append_seconds(text, point.t_ns);
    for (const double value : {pose.x + (point.t_ns > 2'000'000'000 ? 1.0 : 0.0), pose.y, pose.yaw,
                               pose.x, pose.y, pose.yaw, 0.1, 0.1, 0.1}) {
      text += ',';
      append_number(text, value);
    }
    text += '\n';
  }
  const auto jumping = scratch_.write("jumping.csv", text).string();
  const auto judged = [&](const std::string& frame) {
    const auto json = nlohmann::json::parse(
        run("--json --reference " + reference_ + " --pose " + jumping + frame).out);
    return std::pair{json["frame"], json["estimates"][0]};
  };
  const auto [map_name, map] = judged(" --align none");
  EXPECT_EQ(map_name, "map");
  EXPECT_NEAR(map["end_error"], 1.0, 1e-9);
  EXPECT_FALSE(map["nees"].is_null());
  // Aligned at the start, where the covariance is as large as at the end.
  EXPECT_TRUE(judged("").second["nees"].is_null());
  const auto [odom_name, odom] = judged(" --frame odom");
  EXPECT_EQ(odom_name, "odom");
  EXPECT_NEAR(odom["end_error"], 0.0, 1e-9);
  EXPECT_TRUE(odom["nees"].is_null());  // the covariance is that of the map's pose

  EXPECT_THAT(run(both() + good_ + " --frame odom"),
              Ends(2, HasSubstr(R"(:1: no column "odom_x")")));
}

}  // namespace
}  // namespace odomd::tools::evaluate_test
