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
    reference_ = write("ref.csv", wavy_drive(0.0, 4.2, 0.01));
    good_ = write("good.csv", wavy_drive(0.0, 4.0, 0.005));
    Trajectory drift = wavy_drive(0.0, 4.0, 0.005);
    for (auto& point : drift.points) point.pose.x *= 1.02;
    drift_ = write("drift.csv", drift);
  }
  static Outcome run(const std::string& arguments) {
    return run_shell("odom evaluate " + arguments);
  }
  static nlohmann::json json_of(const std::string& arguments) {
    return nlohmann::json::parse(run("--json " + arguments).out);
  }
  [[nodiscard]] std::string write(const std::string& name, const Trajectory& trajectory) const {
    return scratch_.write(name, csv_of(trajectory)).string();
  }
  [[nodiscard]] std::string both() const { return "--reference " + reference_ + " --pose "; }
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
  const auto estimates = json_of(both() + drift_ + " --pose " + good_)["estimates"];
  ASSERT_EQ(estimates.size(), 2U);
  EXPECT_EQ(estimates[0]["pose"], drift_);
  EXPECT_EQ(estimates[0]["samples"], 801);
  EXPECT_GT(estimates[0]["end_error"], estimates[1]["end_error"]);
  EXPECT_GT(estimates[1]["improvement_percent"]["end_error"], 99.0);
  EXPECT_TRUE(estimates[1]["nees"].is_null());
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

TEST_F(Evaluate, WarnsOfWhatMakesTheFiguresDoubtful) {
  const std::string whole = contents(good_);
  const auto cut = scratch_.write("cut.csv", whole.substr(0, whole.size() - 40)).string();
  const auto early = write("early.csv", wavy_drive(0.0, 2.0, 0.01));
  const auto part = write("part.csv", wavy_drive(1.0, 2.0, 0.005));
  Trajectory turning = wavy_drive(0.0, 5.0, 0.01), in_degrees = wavy_drive(0.0, 8.0, 0.005);
  for (auto& point : turning.points) point.pose.yaw = 0.6 * static_cast<double>(point.t_ns) * 1e-9;
  for (auto& point : in_degrees.points) point.pose.yaw *= 180.0 / 3.14159265358979;
  const auto other = write("other.csv", turning), degrees = write("degrees.csv", in_degrees);
  std::string rows = "t,x,y,yaw,sigma_x,sigma_y,sigma_yaw\n";
  for (int i = 0; i < 5; ++i) rows += std::to_string(i) + ",0,0,0,.1,.1,.1\n";
  const auto with_sigmas = scratch_.write("poses.csv", rows).string();
  Trajectory moved = wavy_drive(0.0, 40.0, 0.01);
  for (auto& point : moved.points)
    if (point.t_ns > 20'000'000'000) point.t_ns += 60'000'000;
  const auto late = write("late.csv", moved),
             long_drive = write("l.csv", wavy_drive(0.0, 40.0, 0.005));
  constexpr auto exchanged = "check whether --reference and --pose are exchanged";
  constexpr auto headings = ": the headings do not follow the path";
  const std::string warning = "odom evaluate: warning: ";

  const std::vector<std::pair<std::string, ::testing::Matcher<std::string>>> cases{
      {both() + cut, HasSubstr("warning: " + cut + ":802: the last line is cut off")},
      {"--reference " + early + " --pose " + good_,
       warning + good_ +
           ": the reference covers 2.0 s of 4.0 s; the rest is not evaluated [W412]\n"},
      {both() + part + " --pose " + good_,
       AllOf(HasSubstr("warning: " + part +
                       ": it covers 1.0 s and 0.8 m of the reference's 4.2 s and 4.2 m; all "
                       "figures are for that part only [W413]\n"),
             Not(HasSubstr(good_ + ": it covers")))},
      // No warning for a requested part, unless the file covers less.
      {both() + good_ + " --from +1 --to +2", ""},
      {both() + part + " --from +0.5 --to +3", HasSubstr(part + ": it covers 1.0 s")},
      // The times are off in the part that is evaluated, or not.
      {"--reference " + late + " --pose " + long_drive + " --to +20", ""},
      {"--reference " + late + " --pose " + long_drive + " --from +21",
       StartsWith(warning + late + ": its times look 60 ms late compared with the poses")},
      {both() + other, HasSubstr(other + ": its turns disagree with the reference's")},
      {"--reference " + with_sigmas + " --pose " + good_, HasSubstr(exchanged)},
      {"--reference " + good_ + " --pose " + with_sigmas, Not(HasSubstr(exchanged))},
      {"--reference " + degrees + " --pose " + good_, HasSubstr(degrees + headings)},
      {both() + degrees, HasSubstr(degrees + headings)}};
  for (const auto& [arguments, matcher] : cases)
    EXPECT_THAT(run(arguments), Ends(0, matcher)) << arguments;
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

TEST_F(Evaluate, WrongUsageIsStatusTwoWithTheFix) {
  const auto bad = [&](const std::string& name, const std::string& rows) {
    return both() + scratch_.write(name, "t,x,y,yaw\n" + rows).string();
  };
  const std::string window = both() + good_;
  std::vector<std::pair<std::string, ::testing::Matcher<std::string>>> cases{
      {"", HasSubstr("--pose or --drive is required; see odom evaluate --help")},
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
      {both() + "/", HasSubstr("/")},
      {both() + good_ + " --frame odom", HasSubstr(R"(:1: no column "odom_x")")},
      {bad("nan.csv", "0,0,nan,0\n"), HasSubstr(R"(:2: column "y": "nan" is not a finite number)")},
      {bad("apart.csv", "100,0,0,0\n101,0,0,0\n"), HasSubstr("fewer than two common times")},
      {bad("far.csv", "9223372036.8,0,0,0\n"),
       HasSubstr(R"(:2: column "t": "9223372036.8" is not a time in seconds)")},
      {window + " --from +60",
       "odom evaluate: " + good_ +
           ": no row within --from and --to; its times are 0.000000000 to 4.000000000\n"},
      {window + " --from 3 --to 2", HasSubstr("no row within --from and --to")},
      {window + " --to 0", HasSubstr("fewer than two common times")},
      {window + " --from -90000", HasSubstr("lies more than a day before")}};
  for (const std::string time : {"+", "x", "++1", "1e999", "+9223372036.9"})
    for (const std::string option : {"--from", "--to"})
      cases.emplace_back(window + " " + option + " " + time,
                         HasSubstr(option + ": \"" + time + "\" is not a time"));
  expect_refused("odom evaluate ", cases);
}

TEST_F(Evaluate, JudgesAWindowAlignedAtItsBegin) {
  const auto judged = [&](const std::string& window) {
    return json_of(both() + drift_ + " " + window)["estimates"][0];
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
    const auto json = json_of(both() + jumping + frame);
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
}

}  // namespace
}  // namespace odomd::tools::evaluate_test
