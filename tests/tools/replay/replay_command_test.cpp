// odom replay: its findings about implausible drives.
#include <fmt/format.h>

#include "tests/tools/scratch.hpp"

namespace odomd::tools::replay_command_test {
namespace {

class OdomReplay : public testing::Test {
 protected:
  [[nodiscard]] Outcome replay(const std::string& log, const std::string& more = "") const {
    scratch_.write("drive.log", log);
    return scratch_.run("odom replay --config car.toml --can drive.log" + more +
                        (more.find("--out") == std::string::npos ? " --out pose.csv" : ""));
  }
  [[nodiscard]] bool exists(const char* name) const {
    return std::filesystem::exists(scratch_.path(name));
  }
  void write_camera(const std::string& rows) const {
    scratch_.write("camera.csv", "t_arrival,t_capture,x,y,yaw,sigma_x,sigma_y,sigma_yaw\n" + rows);
  }
  OdomReplay() {
    scratch_.write("car.dbc",
                   "BO_ 257 WHEEL: 3 X\n SG_ CRC : 0|8@1+ (1,0) [0|0] \"\" X\n"
                   " SG_ V : 8|16@1- (0.001,0) [0|0] \"m/s\" X\n"
                   "BO_ 258 STEER: 1 X\n SG_ A : 0|8@1- (0.01,0) [0|0] \"rad\" X\n");
    scratch_.write(
        "car.toml",
        "[can]\ndbc = \"car.dbc\"\n[can.e2e]\nWHEEL = { profile = \"SAE_J1850\", crc = \"CRC\" }\n"
        "[can.signals]\nwheel_rear = { message = \"WHEEL\", signal = \"V\", unit = \"m/s\" }\n"
        "steering = { message = \"STEER\", signal = \"A\", unit = \"rad\" }\n");
  }
  Scratch scratch_;
};

TEST_F(OdomReplay, SaysWhichMessagesNeverGaveAValue) {
  const Outcome outcome =
      replay("(1.000000) can0 101#000000\n(1.010000) can0 101#00\n(1.020000) can0 7FF#\n");
  EXPECT_EQ(outcome.status, 1);  // because there is no pose
  EXPECT_THAT(outcome.err,
              HasSubstr("message 'WHEEL' (wheel_rear): none of its 2 frames gave a value: "
                        "1 failed their protection, 1 are too short"));
  EXPECT_THAT(outcome.err, HasSubstr("message 'STEER' (steering): no frame of it is in the log"));
  EXPECT_THAT(replay("(1.000000) can0 102#00\n").err, Not(HasSubstr("STEER")));
}

TEST_F(OdomReplay, SaysThatALogIsOutOfOrder) {
  const std::string frame = ") can0 102#00\n";
  EXPECT_THAT(replay("(9.000000" + frame + "(1.000000" + frame + "(9.100000" + frame).err,
              HasSubstr("1 frames have stamps 1 s or more earlier than frames before them"));
  EXPECT_THAT(replay("(9.000000" + frame + "(8.900000" + frame).err, Not(HasSubstr("have stamps")));
}

TEST_F(OdomReplay, RefusesADamagedLogOnlyWhenStrict) {
  const std::string log = "(1.000000) can0 101#95E803\n(1.00\n# wet\n(1.010000) can0 101#95E803\n";
  EXPECT_THAT(replay(log, " --model kinematic"),
              Ends(0, AllOf(HasSubstr("drive.log:2: the log is damaged here: 1 line is left out"),
                            HasSubstr("drive.log:3: 1 line is no frame"), HasSubstr("[W201]"))));
  EXPECT_THAT(replay(log, " --model kinematic --strict"),
              Ends(2, HasSubstr("drive.log:2: expected 6 or 9 decimals")));
  for (const std::string command :
       {"dbc decode --dbc car.dbc drive.log", "init --dbc car.dbc --out new.toml --can drive.log",
        "fault --config car.toml --kind wheel_rear.zero --out /dev/null drive.log",
        "doctor --drive .", "evaluate --drive .", "export --drive . --mcap drive.mcap",
        "identify latency --config car.toml --can drive.log",
        "identify noise --config car.toml --can drive.log"})
    EXPECT_THAT(scratch_.run("odom " + command + " --strict"),
                Ends(2, HasSubstr("drive.log:2: expected 6 or 9 decimals")))
        << command;
}

TEST_F(OdomReplay, RefusesALogInWhichNoTimePassesOrHoursPassAtOnce) {
  for (const std::string stamp : {"0.000000", "1700000000.250000"}) {
    std::string log = "\n";
    for (int i = 0; i < 150; ++i) log += "(" + stamp + ") can0 102#00\n";
    EXPECT_THAT(
        replay(log),
        Ends(2, HasSubstr("drive.log:151: all 150 frames so far have the time stamp " + stamp)));
    EXPECT_FALSE(exists("pose.csv"));
  }
  EXPECT_THAT(replay("(1.000000) can0 102#00\n\n(9000.000000) can0 102#00\n"),
              Ends(2, HasSubstr("drive.log:3: the log pauses for more than an hour")));
}

TEST_F(OdomReplay, OverwritesNoInput) {
  const std::string log = "(1.000000) can0 101#95E803\n(1.010000) can0 102#00\n";
  scratch_.write("camera.csv", "t_arrival,t_capture,x,y,yaw\n");
  scratch_.write("drive.log", log);
  for (const std::string file : {"drive.log", "car.toml", "car.dbc", "camera.csv"}) {
    const std::string before = scratch_.text(file);
    for (const std::string option : {" --out ", " --out /dev/null --innovations "})
      EXPECT_THAT(replay(log, " --camera camera.csv" + option + file),
                  Ends(2, HasSubstr(file + " is what is read; name another file")));
    EXPECT_EQ(scratch_.text(file), before);
  }
  for (const std::string both : {"both.csv", "-"})
    EXPECT_THAT(replay(log, " --out " + both + " --innovations " + both).err,
                HasSubstr("--innovations: " + both + " is --out too; name another file"));
}

TEST_F(OdomReplay, LeavesNoPoseFileOfADriveThatFailed) {
  scratch_.write("pose.csv", "an earlier one");
  const std::string pause = "(1.000000) can0 101#95E803\n(9000.000000) can0 102#00\n";
  for (const auto& [log, status] : {std::pair{pause, 2}, {"(1.000000) can0 102#00\n", 1}}) {
    EXPECT_EQ(replay(log).status, status);
    EXPECT_EQ(scratch_.text("pose.csv"), "an earlier one");
    EXPECT_EQ(scratch_.run("ls | grep partial").out, "");
  }
  EXPECT_EQ(replay("(1.000000) can0 101#95E803\n", " --model kinematic").status, 0);
  EXPECT_THAT(scratch_.text("pose.csv"), StartsWith("t,x,y,yaw,"));
  EXPECT_EQ(scratch_.run("ls | grep partial").out, "");
}

TEST_F(OdomReplay, NamesTheFolderThatAFileCannotGoInto) {
  EXPECT_THAT(replay("(1.000000) can0 102#00\n", " --out nowhere/pose.csv"),
              Ends(2,
                   "odom replay: nowhere/pose.csv: cannot be written: there is no folder nowhere; "
                   "create it, or check the path\n"));
}

TEST_F(OdomReplay, WritesThroughLinksAndIntoPipes) {
  std::filesystem::create_symlink("elsewhere.csv", scratch_.path("pose.csv"));
  EXPECT_EQ(replay("(1.000000) can0 101#95E803\n", " --model kinematic").status, 0);
  EXPECT_TRUE(std::filesystem::is_symlink(scratch_.path("pose.csv")));
  EXPECT_THAT(scratch_.text("elsewhere.csv"), StartsWith("t,x,y,yaw,"));
  EXPECT_THAT(
      scratch_.run("odom replay --config car.toml --can drive.log --out /dev/stdout | cat").out,
      StartsWith("t,x,y,yaw,"));
}

TEST_F(OdomReplay, SaysThatTheCameraIsMissing) {
  constexpr auto note = "[W111]";
  const std::string log = "(1.000000) can0 102#00\n";
  EXPECT_THAT(replay(log).err, Not(HasSubstr(note)));
  scratch_.write("car.toml", scratch_.text("car.toml") + "[camera]\n");
  EXPECT_THAT(replay(log).err, HasSubstr(note));
  // A file without a pose: the drive begins at 0.
  write_camera("");
  EXPECT_THAT(replay("(1.000000) can0 101#95E803\n", " --model kinematic --camera camera.csv"),
              Ends(0, HasSubstr("camera.csv: contains no camera pose")));
  EXPECT_THAT(scratch_.text("pose.csv"), HasSubstr("\n1.000000000,0,0,0,1,0,0,"));
}

TEST_F(OdomReplay, SaysThatALogIsCutInMidFrame) {
  const std::string whole = "(1.000000) can0 101#95E803\n(1.010000) can0 101#95E803";
  constexpr auto warning = "message 'WHEEL' (wheel_rear): 1 of its frames ended before its signals";
  EXPECT_THAT(replay(whole + "\n").err, Not(HasSubstr(warning)));
  EXPECT_THAT(replay(whole.substr(0, whole.size() - 2)).err, HasSubstr(warning));
}

TEST_F(OdomReplay, SaysSinceWhenThePoseIsFaulty) {
  // 1 m/s, then -1 m/s, where the paper's filter does not work.
  std::string log;
  for (int i = 0; i < 100; ++i)
    log += fmt::format("(1.{:02}0000) can0 101#{}\n", i, i < 50 ? "95E803" : "FA18FC");
  scratch_.write("car.toml",
                 std::regex_replace(scratch_.text("car.toml"), std::regex("WHEEL = .*"), ""));
  EXPECT_THAT(replay(log, " --model paper"),
              Ends(0, AllOf(HasSubstr("the mode is fault from t = 1.5"),
                            HasSubstr("model_fault: the model left its valid range and stopped"))));
}

TEST_F(OdomReplay, SaysThatTheCameraSawAnotherDrive) {
  const std::string log = "(100.000000) can0 101#95E803\n(101.000000) can0 101#95E803\n";
  constexpr auto warning = "none of the 1 camera poses arrives while the log lasts";
  const auto said_of = [&](const std::string& arrival) {
    write_camera(arrival + ",99,0,0,0,1,1,1\n");
    return replay(log, " --camera camera.csv").err;
  };
  EXPECT_THAT(said_of("99.5"), HasSubstr(warning));
  EXPECT_THAT(said_of("100.5"), Not(HasSubstr(warning)));
  EXPECT_THAT(said_of("200"), HasSubstr(warning));
}

TEST_F(OdomReplay, SaysThatTheInitialPoseIsOfAnotherDrive) {
  const std::string log = "(100.000000) can0 101#95E803\n(101.000000) can0 101#95E803\n";
  constexpr auto warning = "lies 3.00 m and 0 deg from what the camera saw first: it is of another";
  const auto said_from = [&](const std::string& initial, const std::string& capture) {
    write_camera("100.5," + capture + ",3,1,0.5,.01,.01,.01\n");
    return replay(log, " --camera camera.csv --initial=" + initial).err;
  };
  EXPECT_THAT(said_from("0,1,0.5", "100.02"), HasSubstr(warning));
  EXPECT_THAT(said_from("2.9,1,0.4", "100.02"), Not(HasSubstr("another drive")));
  EXPECT_THAT(said_from("3,1,3.4", "100.02"), HasSubstr("lies 0.00 m and 166 deg"));
  EXPECT_THAT(said_from("0,1,0.5", "100.45"), Not(HasSubstr("another drive")));  // after driving
}

TEST_F(OdomReplay, SaysWhyThereIsNoPose) {
  write_camera("500,499,0,0,0,1,1,1\n");
  EXPECT_THAT(
      replay("(1.000000) can0 102#00\n", " --camera camera.csv"),
      Ends(1, AllOf(HasSubstr("[W208]"),
                    HasSubstr("\nodom replay: there is no pose: no pose file is written\n"))));
  EXPECT_FALSE(exists("pose.csv"));
}

TEST(ReplayCommand, ReportsTheInnovationsAndTheNoiseOfTheFullFilter) {
  const Scratch scratch;
  simulate(scratch, "--duration 8");
  const auto replayed = [&](const std::string& model) {
    const Outcome outcome =
        scratch.run("odom replay --json --drive drive --out pose.csv --model " + model);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return nlohmann::json::parse(outcome.err);
  };
  for (const char* other : {"paper", "kinematic"}) {
    EXPECT_TRUE(replayed(other)["innovations"].empty());
    EXPECT_TRUE(replayed(other)["noise"].empty());
  }
  const auto full = replayed("full");
  EXPECT_TRUE(full.at("warnings").empty());
  EXPECT_EQ(full.at("wiring"), nlohmann::json::object());
  const auto& tested = full["innovations"];
  EXPECT_THAT(tested, Includes(R"({"yaw_rate": {"dimension": 1}, "camera": {"dimension": 3}})"));
  EXPECT_GT(tested["yaw_rate"]["count"], 1000);
  EXPECT_GT(tested["yaw_rate"]["mean_nis"], 0.0);
  EXPECT_GT(tested["camera"]["count"], 200);
  EXPECT_GT(tested["wheel_rear_left"]["inside_95"], 0.5);
  EXPECT_FALSE(tested.contains("steering"));

  const auto& noise = full["noise"];
  for (const char* source : {"yaw_rate", "accel_x", "accel_y"}) {
    const double stated = noise[source]["sigma"], moving = noise[source]["moving"];
    EXPECT_GT(stated, 0.0) << source;
    EXPECT_GE(moving, 0.3 * stated) << source;
    EXPECT_LE(moving, 3.0 * stated) << source;
    EXPECT_TRUE(noise[source]["speed_share"].is_null()) << source;
  }
  EXPECT_GT(noise["wheel_rear_left"]["speed_share"], 0.0);
  EXPECT_LT(noise["wheel_rear_left"]["speed_share"], 0.05);
  EXPECT_TRUE(noise["wheel_rear_left"]["moving"].is_null());
  EXPECT_FALSE(noise.contains("steering"));
}

}  // namespace
}  // namespace odomd::tools::replay_command_test
