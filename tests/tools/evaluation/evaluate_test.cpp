// odom evaluate as a command.
#include "tests/tools/drives.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/cli/csv.hpp"

namespace odomd::tools::evaluate_test {
namespace {

class Evaluate : public ::testing::Test {
 protected:
  Evaluate() {
    write("ref.csv", wavy_drive(0.0, 4.2, 0.01));
    write("good.csv", wavy_drive(0.0, 4.0, 0.005));
    Trajectory drift = wavy_drive(0.0, 4.0, 0.005);
    for (auto& point : drift.points) point.pose.x *= 1.02;
    write("drift.csv", drift);
  }
  [[nodiscard]] Outcome run(const std::string& arguments) const {
    return scratch_.run("odom evaluate " + arguments);
  }
  [[nodiscard]] nlohmann::json json_of(const std::string& arguments) const {
    return scratch_.json("odom evaluate --json " + arguments);
  }
  void write(const std::string& name, const Trajectory& trajectory) const {
    scratch_.write(name, csv_of(trajectory));
  }
  Scratch scratch_;
};

TEST_F(Evaluate, WritesATableWithAColumnAPoseFileAndAPicture) {
  const Outcome outcome =
      run("--reference ref.csv --pose drift.csv --pose good.csv --picture lap.svg");
  EXPECT_THAT(outcome, Ends(0, ""));
  // Three rows of short horizons; the others are only in JSON.
  for (const char* part :
       {"drift", "end error [cm/m]", "end error better by [%]", "35 ms error mean [mm]",
        "35 ms yaw error mean [deg]", "1000 ms error mean"})
    EXPECT_THAT(outcome.out, HasSubstr(part));
  EXPECT_THAT(outcome.out, Not(ContainsRegex("35 ms.* max|\n100 ms|\n5 ms")));
  EXPECT_THAT(scratch_.text("lap.svg"), StartsWith("<svg"));
}

TEST_F(Evaluate, WritesJsonInTheOrderAndWithTheTimesOfTheFiles) {
  const auto estimates =
      json_of("--reference ref.csv --pose drift.csv --pose good.csv")["estimates"];
  ASSERT_EQ(estimates.size(), 2U);
  EXPECT_THAT(estimates[0], Includes(R"({"pose": "drift.csv", "samples": 801})"));
  EXPECT_GT(estimates[0]["end_error"], estimates[1]["end_error"]);
  EXPECT_GT(estimates[1]["improvement_percent"]["end_error"], 99.0);
  EXPECT_TRUE(estimates[1]["nees"].is_null());
  std::string rows = "t,x,y,yaw\n";
  for (int i = 0; i < 20; ++i)
    rows += "17600000" + std::to_string(10 + i) + ".55," + std::to_string(i) + ",0,0\n";
  scratch_.write("late.csv", rows);
  EXPECT_THAT(
      run("--json --reference late.csv --pose late.csv").out,
      AllOf(HasSubstr("\"t_first\": 1760000010.55,"), HasSubstr("\"t_last\": 1760000029.55,")));
}

TEST_F(Evaluate, ReportsTheGivenOrFittedLeverArm) {
  EXPECT_THAT(
      run("--reference ref.csv --pose good.csv --lever-arm -0.1,0,0").out,
      HasSubstr("lever arm  -0.1000 m, 0.0000 m, 0.00 deg of the reference point, as given"));
  EXPECT_THAT(run("--reference ref.csv --pose good.csv --fit-lever-arm").out,
              HasSubstr("fitted to"));
}

TEST_F(Evaluate, DoesNotOverwriteItsInputsAndSaysWhyAReportCannotBeWritten) {
  simulate(scratch_, "--ideal --duration 1");
  for (const std::string file : {"drive/car.toml", "drive/car.dbc", "drive/drive.log",
                                 "drive/camera.csv", "drive/truth.csv"}) {
    const std::string text = scratch_.text(file);
    EXPECT_THAT(run("--drive drive --html drive/../" + file).err, HasSubstr("is what is read"));
    EXPECT_EQ(scratch_.text(file), text) << file;
  }
  EXPECT_THAT(run("--reference ref.csv --pose good.csv --html /dev/full"),
              Ends(1, "odom evaluate: /dev/full: cannot be written: No space left on device\n"));
}

TEST_F(Evaluate, WarnsOfInputsThatMakeTheFiguresDoubtful) {
  const std::string whole = scratch_.text("good.csv");
  scratch_.write("cut.csv", whole.substr(0, whole.size() - 40));
  write("early.csv", wavy_drive(0.0, 2.0, 0.01));
  write("part.csv", wavy_drive(1.0, 2.0, 0.005));
  Trajectory turning = wavy_drive(0.0, 5.0, 0.01), in_degrees = wavy_drive(0.0, 8.0, 0.005);
  for (auto& point : turning.points) point.pose.yaw = 0.6 * static_cast<double>(point.t_ns) * 1e-9;
  for (auto& point : in_degrees.points) point.pose.yaw *= 180.0 / 3.14159265358979;
  write("other.csv", turning);
  write("degrees.csv", in_degrees);
  std::string rows = "t,x,y,yaw,sigma_x,sigma_y,sigma_yaw\n";
  for (int i = 0; i < 5; ++i) rows += std::to_string(i) + ",0,0,0,.1,.1,.1\n";
  scratch_.write("sigmas.csv", rows);
  Trajectory moved = wavy_drive(0.0, 40.0, 0.01);
  for (auto& point : moved.points)
    if (point.t_ns > 20'000'000'000) point.t_ns += 60'000'000;
  write("late.csv", moved);
  write("long.csv", wavy_drive(0.0, 40.0, 0.005));
  // A requested part gives no warning, unless the file covers less. In late.csv the times are off
  // only after 20 s; --from selects that part, --to excludes it.
  expect_answers(scratch_, 0, "odom evaluate --reference", R"(
ref.csv --pose cut.csv -> warning: cut.csv:802: the last line is cut off
early.csv --pose good.csv -> odom evaluate: warning: good.csv: the reference covers 2.0 s of 4.0 s;
  the rest is not evaluated [W412]
ref.csv --pose part.csv --from +0.5 --to +3 -> part.csv: it covers 1.0 s
late.csv --pose long.csv --from +21 -> warning: late.csv: its times look 60 ms late compared with
  the poses
ref.csv --pose other.csv -> other.csv: its turns disagree with the reference's
sigmas.csv --pose good.csv -> check whether --reference and --pose are exchanged
degrees.csv --pose good.csv -> degrees.csv: the headings do not follow the path
ref.csv --pose degrees.csv -> degrees.csv: the headings do not follow the path
)");
  EXPECT_THAT(run("--reference ref.csv --pose part.csv --pose good.csv"),
              Ends(0, AllOf(HasSubstr("warning: part.csv: it covers 1.0 s and 0.8 m of the "
                                      "reference's 4.2 s and 4.2 m; all figures are for that part "
                                      "only [W413]\n"),
                            Not(HasSubstr("good.csv: it covers")))));
  EXPECT_THAT(run("--reference ref.csv --pose good.csv --from +1 --to +2"), Ends(0, ""));
  EXPECT_THAT(run("--reference late.csv --pose long.csv --to +20"), Ends(0, ""));
  EXPECT_THAT(run("--reference good.csv --pose sigmas.csv"), Ends(0, Not(HasSubstr("exchanged"))));
}

// The text of a drive's file, with its first `columns` columns increased by `seconds`.
std::string later(const std::string& file, std::size_t columns, double seconds) {
  std::istringstream text(file);
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

TEST_F(Evaluate, SaysWhichTimesAreOffInADrive) {
  simulate(scratch_, "--duration 30 --standstill 1", "lap");
  const std::string truth = scratch_.text("lap/truth.csv");
  const auto warnings = [&](const std::string& how = "") {
    const Outcome outcome = run("--drive lap" + how);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return outcome.err;
  };
  EXPECT_EQ(warnings(), "");
  EXPECT_EQ(warnings(" --dead-reckoning"), "");

  scratch_.write("lap/truth.csv", later(truth, 1, 0.08));
  constexpr auto of_reference = "/truth.csv: its times look 80 ms late against the bus";
  EXPECT_THAT(warnings(), HasSubstr(of_reference));
  EXPECT_THAT(warnings(" --dead-reckoning"), HasSubstr(of_reference));

  scratch_.write("lap/camera.csv", later(scratch_.text("lap/camera.csv"), 2, 0.08));
  EXPECT_THAT(warnings(" --model full"), HasSubstr("/truth.csv, camera.csv: their times look 8"));

  scratch_.write("lap/truth.csv", truth);
  EXPECT_THAT(warnings(),
              HasSubstr("warning: lap: camera.csv: its times look 80 ms late against the bus"));
}

TEST_F(Evaluate, WrongUsageIsStatusTwoWithTheFix) {
  scratch_.write("nan.csv", "t,x,y,yaw\n0,0,nan,0\n");
  scratch_.write("apart.csv", "t,x,y,yaw\n100,0,0,0\n101,0,0,0\n");
  scratch_.write("far.csv", "t,x,y,yaw\n9223372036.8,0,0,0\n");
  expect_answers(scratch_, 2, "odom evaluate", R"(
 -> --pose or --drive is required; see odom evaluate --help
--pose good.csv -> --reference (or --closed-loop) is required; see odom evaluate --help
--reference /nonexistent.csv --pose good.csv -> odom evaluate: /nonexistent.csv: no such file or
  directory; check the path
)");
  expect_answers(scratch_, 2, "odom evaluate --reference ref.csv --pose", R"(
good.csv --align last -> --align: "last" is none of first|fit|none
good.csv --lever-arm 1,2 -> --lever-arm
good.csv --lever-arm 1,nan,2 -> --lever-arm
good.csv --html good.csv -> odom evaluate: --html: good.csv is what is read; name another file
good.csv --html - -> odom evaluate: --html: - is the summary too; name another file
/ -> /
good.csv --frame odom -> :1: no column "odom_x"
nan.csv -> :2: column "y": "nan" is not a finite number
apart.csv -> fewer than two common times
far.csv -> :2: column "t": "9223372036.8" is not a time in seconds
good.csv --from +60 -> odom evaluate: good.csv: no row within --from and --to; its times are
  0.000000000 to 4.000000000
good.csv --from 3 --to 2 -> no row within --from and --to
good.csv --to 0 -> fewer than two common times
good.csv --from -90000 -> lies more than a day before
)");
  for (const std::string time : {"+", "x", "++1", "1e999", "+9223372036.9"})
    for (const std::string option : {"--from", "--to"})
      EXPECT_THAT(run("--reference ref.csv --pose good.csv " + option + " " + time),
                  Ends(2, HasSubstr(option + ": \"" + time + "\" is not a time")));
}

TEST_F(Evaluate, JudgesAWindowAlignedAtItsBegin) {
  const auto judged = [&](const std::string& window) {
    return json_of("--reference ref.csv --pose drift.csv " + window)["estimates"][0];
  };
  const auto relative = judged("--from +1 --to +3");
  EXPECT_THAT(relative, Includes(R"({"samples": 401, "t_first": 1.0, "t_last": 3.0})"));
  EXPECT_NEAR(relative["path_length"], 2.0, 1e-4);
  // x is stretched by 2 %: the error over all four seconds is larger than over two.
  EXPECT_LT(relative["end_error"], judged("")["end_error"]);
  EXPECT_GT(relative["end_error"], 0.0);
  EXPECT_EQ(judged("--from 1 --to 3"), relative);
  EXPECT_EQ(judged("--from 3.5")["samples"], 101);
  EXPECT_EQ(judged("--to 0.5")["samples"], 101);
}

TEST_F(Evaluate, JudgesTheOdometryFrame) {
  // The map pose jumps by a metre during the drive; the pose in the odometry frame does not.
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
  scratch_.write("jumping.csv", text);
  const auto judged = [&](const std::string& frame) {
    const auto json = json_of("--reference ref.csv --pose jumping.csv" + frame);
    return std::pair{json["frame"], json["estimates"][0]};
  };
  const auto [map_name, map] = judged(" --align none");
  EXPECT_EQ(map_name, "map");
  EXPECT_NEAR(map["end_error"], 1.0, 1e-9);
  EXPECT_FALSE(map["nees"].is_null());
  // Alignment at the start leaves no NEES: there the covariance is as large as at the end.
  EXPECT_TRUE(judged("").second["nees"].is_null());
  const auto [odom_name, odom] = judged(" --frame odom");
  EXPECT_EQ(odom_name, "odom");
  EXPECT_NEAR(odom["end_error"], 0.0, 1e-9);
  EXPECT_TRUE(odom["nees"].is_null());  // the covariance is that of the map's pose
}

}  // namespace
}  // namespace odomd::tools::evaluate_test
