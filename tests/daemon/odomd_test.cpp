// The daemon as its users see it: a program is started, receives inputs, and is read by others.
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <map>
#include <memory>
#include <sstream>

#include "daemon_process.hpp"

namespace odomd::testing::odomd_test {
namespace {

class OdomdTest : public ::testing::Test {
 protected:
  /// Plays a log to its end; returns the exit status.
  [[nodiscard]] int play(const std::string& log, std::vector<std::string> options = {}) const {
    desk_.write("drive.log", log);
    options.insert(options.end(), {"--can", desk_.file("drive.log"), "--exit-at-end"});
    return DaemonProcess(desk_, options).wait();
  }
  Desk desk_;
};

TEST_F(OdomdTest, PublishesAPoseEveryPeriodAndCountsEveryCycle) {
  DaemonProcess odomd(desk_, {});
  const Client client = open_client(desk_);
  odomd.feed(straight_drive(2.0, 1.0));

  odom_pose pose = await_pose(client, [](const odom_pose& p) { return p.vx > 0.9; });
  odom_info info{};
  ASSERT_EQ(odom_get_info(client.get(), &info, sizeof info), ODOM_OK);
  EXPECT_EQ(info.period_ns, 5'000'000);
  EXPECT_STREQ(info.model, "full");
  EXPECT_EQ(info.first_tick_ns % info.period_ns, 0);
  EXPECT_NE(info.log_offset_ns, 0);

  const odom_pose first = pose;
  odom_pose before = pose;
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(next_pose(client, pose));
    ASSERT_GT(pose.tick, before.tick);
    ASSERT_EQ(pose.time_ns, info.first_tick_ns + static_cast<std::int64_t>(pose.tick) * 5'000'000);
    before = pose;
  }
  // 1 m/s along x.
  EXPECT_NEAR(pose.x - first.x, static_cast<double>(pose.time_ns - first.time_ns) * 1e-9, 0.05);
  EXPECT_NEAR(pose.y, 2.0, 1e-6);

  EXPECT_EQ(odomd.end_by(SIGTERM), 0) << desk_.read("stderr");
  EXPECT_TRUE(becomes_stale(client, pose));
  odom_beat beat{};
  ASSERT_EQ(odom_get_beat(client.get(), &beat, sizeof beat), ODOM_STALE);
  EXPECT_EQ(beat.ticks + beat.missed, pose.tick);
  EXPECT_GT(beat.ticks, 100U);
  for (const char* name : {"camera.sock", "status.sock", "record.sock"})
    EXPECT_FALSE(std::filesystem::exists(desk_.file(name))) << name;
}

TEST_F(OdomdTest, PlaysALogToItsEnd) {
  EXPECT_EQ(play(straight_drive(0.5, 2.0), {"--initial", "5,6,0", "--model", "kinematic"}), 0);
  odom_pose pose{};
  ASSERT_TRUE(becomes_stale(open_client(desk_), pose));
  EXPECT_NE(pose.conditions & ODOM_COND_INPUT_ENDED, 0U);
  EXPECT_GT(pose.x, 5.9);
  EXPECT_NEAR(pose.y, 6.0, 1e-9);
  EXPECT_THAT(desk_.read("stderr"),
              AllOf(HasSubstr("has ended after 150 frames"), Not(HasSubstr("overdue"))));
}

TEST_F(OdomdTest, ReportsASignalThatStopsBeforeItsLogAsOverdue) {
  std::istringstream lines(straight_drive(1.0, 2.0));
  std::string log;
  int gyro = 0;
  for (std::string line; std::getline(lines, line);)
    if (line.find(" 101#") == std::string::npos || ++gyro <= 30) log += line + '\n';
  ASSERT_EQ(gyro, 100);
  EXPECT_EQ(play(log), 0);
  EXPECT_THAT(desk_.read("stderr"), HasSubstr("yaw_rate (GYRO) is overdue"));
}

TEST_F(OdomdTest, FailsOnALogWithoutAMappedFrame) {
  EXPECT_EQ(play("(1700000000.100000) can0 7A2#00\n(1700000000.200000) can0 7A2#00\n"), 1);
  EXPECT_THAT(desk_.read("stderr"), HasSubstr("without a frame of a mapped message"));
}

/// Time, position and heading of each row in a file of poses.
std::map<std::string, std::string> poses_in(const std::string& csv) {
  std::map<std::string, std::string> poses;
  std::istringstream lines(csv);
  for (std::string line; std::getline(lines, line);) {
    const auto after_time = line.find(',');
    if (after_time == std::string::npos) continue;  // a message
    auto end = after_time;
    for (int column = 0; column < 3; ++column) end = line.find(',', end + 1);
    poses[line.substr(0, after_time)] = line.substr(after_time, end - after_time);
  }
  return poses;
}

// On a loaded machine the beat may miss ticks, or frames may be late: then the poses may differ.
// One of several attempts should be free of that.
TEST_F(OdomdTest, PublishesTheSameBitsAsAReplay) {
  std::size_t same = 0;
  std::vector<std::string> different;
  for (int attempt = 0; attempt < 10 && (same <= 100 || !different.empty()); ++attempt) {
    const Desk desk;
    desk.write("drive.log", straight_drive(1.0, 1.5));
    ASSERT_EQ(desk.odom("replay --config car.toml --can drive.log --out replay.csv", "replay.txt"),
              0)
        << desk.read("replay.txt");
    DaemonProcess odomd(desk, {"--can", desk.file("drive.log"), "--exit-at-end"});
    static_cast<void>(desk.odom(
        "pose --shm " + desk.segment() + " --follow --csv --clock log --until-stale --wait 10",
        "live.csv"));
    EXPECT_EQ(odomd.wait(), 0);
    const auto replayed = poses_in(desk.read("replay.csv"));
    same = 0;
    different.clear();
    for (const auto& [time, pose] : poses_in(desk.read("live.csv")))
      if (const auto found = replayed.find(time); found == replayed.end())
        continue;
      else if (found->second == pose)
        ++same;
      else
        different.push_back(time + pose + " for " + found->second);
  }
  EXPECT_GT(same, 100U);
  EXPECT_THAT(different, IsEmpty());
}

TEST_F(OdomdTest, ContinuesAfterTheEndOfItsInput) {
  DaemonProcess odomd(desk_, {});
  const Client client = open_client(desk_);
  odomd.feed(straight_drive(0.1, 1.0));
  odomd.close_input();
  odom_pose pose = await_pose(client, [](const odom_pose& p) {
    return (p.conditions & ODOM_COND_INPUT_ENDED) != 0 &&
           (p.conditions & ODOM_COND_SIGNAL_TIMEOUT) != 0;
  });
  EXPECT_TRUE(next_pose(client, pose));
  EXPECT_TRUE(desk_.logs("warning: mode: degraded ("));
  EXPECT_EQ(odomd.end_by(SIGINT), 0);
  EXPECT_THAT(desk_.read("stderr"), Not(HasSubstr("overdue")));
}

TEST_F(OdomdTest, ReportsItsStatus) {
  DaemonProcess odomd(desk_, {"--camera-socket", desk_.file("ä\xff")});
  odomd.feed("rubbish\n" + straight_drive(1.0, 1.0));
  auto status = desk_.await_status([](auto& now) {
    return now["can"][0]["received"] == 300 && now["can"][0]["malformed"] == 1 &&
           now["pose"]["x"] > 1.0;
  });

  EXPECT_EQ(status["model"], "full");
  EXPECT_EQ(status["pid"], odomd.pid());
  EXPECT_EQ(status["instance"].get<std::string>().size(), 16U);
  EXPECT_EQ(status["shm"], desk_.segment());
  EXPECT_EQ(status["camera"]["socket"], desk_.file("ä\uFFFD").string()) << "\\xff is not UTF-8";
  EXPECT_TRUE(status["mode"] == "dead_reckoning" || status["mode"] == "degraded");
  EXPECT_GT(status["pose"]["sigma_x"], 0.0);
  EXPECT_EQ(status["beat"]["period_s"], 0.005);
  EXPECT_GT(status["beat"]["ticks"], 0);
  EXPECT_GE(status["beat"]["wakeup_us"]["max"], status["beat"]["wakeup_us"]["p50"]);
  EXPECT_EQ(status["can"][0]["name"], "-");
  EXPECT_EQ(status["can"][0]["link"], "up");
  ASSERT_EQ(status["messages"].size(), 3U);
  for (const auto& message : status["messages"]) {
    EXPECT_EQ(message["verdicts"]["decoded"], 100) << message;
    EXPECT_FALSE(message["age_s"].is_null());
  }
  ASSERT_EQ(status["sources"].size(), ODOM_SOURCE_COUNT);
  const auto& wheel = status["sources"][ODOM_SOURCE_WHEEL_REAR];
  EXPECT_EQ(wheel["name"], "wheel_rear");
  EXPECT_EQ(wheel["configured"], true);
  EXPECT_EQ(wheel["last_verdict"], "fused");
  EXPECT_EQ(wheel["verdicts"]["fused"], 100);
  EXPECT_EQ(wheel["timeout_s"], 0.03);
  EXPECT_EQ(wheel["sigma"], 0.05);
  EXPECT_TRUE(wheel["noise"]["at_rest"].is_null());
  EXPECT_TRUE(wheel["noise"]["moving"].is_null());
  EXPECT_GT(wheel["noise"]["speed_share"], 0.0);
  const auto& gyro = status["sources"][ODOM_SOURCE_YAW_RATE];
  EXPECT_EQ(gyro["name"], "yaw_rate");
  EXPECT_GT(gyro["noise"]["moving"], 0.0);
  EXPECT_LE(gyro["noise"]["moving"], gyro["sigma"]);
  EXPECT_TRUE(gyro["noise"]["speed_share"].is_null());
  EXPECT_NE(status["clock"]["log_offset_ns"], 0);
  EXPECT_TRUE(status["realtime"].contains("refusals"));
  EXPECT_EQ(status["events_dropped"], 0);
}

TEST_F(OdomdTest, ResumesWhereItsPredecessorDiedUnlessAPoseIsGiven) {
  auto first = std::make_unique<DaemonProcess>(desk_, std::vector<std::string>{});
  const Client client = open_client(desk_);
  first->feed(straight_drive(5.0, 1.0));
  const odom_pose last = await_pose(client, [](const odom_pose& p) { return p.x > 1.5; });
  odom_info died{};
  ASSERT_EQ(odom_get_info(client.get(), &died, sizeof died), ODOM_OK);
  EXPECT_EQ(first->end_by(SIGKILL), 128 + SIGKILL);

  DaemonProcess second(desk_, {});
  odom_pose pose = last;
  odom_info info{};
  ASSERT_TRUE(eventually([&] {
    const auto status = odom_latest(client.get(), &pose, sizeof pose);
    return status == ODOM_OK && odom_get_info(client.get(), &info, sizeof info) == ODOM_OK &&
           info.instance_id != died.instance_id;
  })) << desk_.read("stderr");
  EXPECT_GE(pose.x, 1.5);
  EXPECT_LT(pose.x, 4.5);
  EXPECT_NE(pose.conditions & ODOM_COND_RESTARTED, 0U);
  EXPECT_GT(pose.reset_count, last.reset_count);
  EXPECT_EQ(pose.mode, static_cast<std::uint32_t>(ODOM_DEGRADED));

  EXPECT_EQ(second.end_by(SIGTERM), 0);
  const DaemonProcess third(desk_, {"--initial", "7,8,0"});
  await_pose(open_client(desk_), [](const odom_pose& p) { return p.x == 7.0; });
}

TEST_F(OdomdTest, FailedStartKeepsThePredecessorsLastPose) {
  DaemonProcess first(desk_, {});
  const Client client = open_client(desk_);
  const odom_pose pose = await_pose(client);
  EXPECT_EQ(first.end_by(SIGKILL), 128 + SIGKILL);
  desk_.write("taken", "by a file that is no socket");
  EXPECT_EQ(DaemonProcess(desk_, {"--can", "/nowhere/drive.log"}).wait(), 2);
  EXPECT_EQ(DaemonProcess(desk_, {"--camera-socket", desk_.file("taken")}).wait(), 1);

  const Client late = open_client(desk_);
  odom_pose last{};
  ASSERT_TRUE(becomes_stale(late, last));
  EXPECT_GE(last.tick, pose.tick);
}

TEST_F(OdomdTest, ReopensItsLogOnHup) {
  desk_.write("car.toml", desk_.read("car.toml") + "[log]\nfile = \"odomd.log\"\n");
  DaemonProcess odomd(desk_, {});
  ASSERT_TRUE(eventually([&] { return !desk_.read("odomd.log").empty(); }));
  std::filesystem::rename(desk_.file("odomd.log"), desk_.file("odomd.log.1"));
  odomd.signal(SIGHUP);
  EXPECT_TRUE(eventually(
      [&] { return desk_.read("odomd.log").find("the log was reopened") != std::string::npos; }));
  EXPECT_EQ(odomd.end_by(SIGTERM), 0);
  EXPECT_THAT(desk_.read("odomd.log"), HasSubstr("stopping: signal TERM"));
  EXPECT_THAT(desk_.read("odomd.log.1"), Not(HasSubstr("stopping")));
}

TEST_F(OdomdTest, ReportsTheSeverityOfALineToTheJournal) {
  desk_.write("stderr", "");
  struct stat error {};
  ASSERT_EQ(::stat(desk_.file("stderr").c_str(), &error), 0);
  ::setenv("JOURNAL_STREAM", fmt::format("{}:{}", error.st_dev, error.st_ino).c_str(), 1);
  const DaemonProcess odomd(desk_, {});
  ::unsetenv("JOURNAL_STREAM");
  EXPECT_TRUE(desk_.logs("<6>info: odomd "));
}

}  // namespace
}  // namespace odomd::testing::odomd_test
