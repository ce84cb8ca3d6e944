// Recording a running daemon, and replaying the recording.
#include <fmt/format.h>

#include <csignal>
#include <memory>

#include "daemon_process.hpp"

namespace odomd::testing::odomd_record_test {
namespace {

/// `odom record`, running in parallel with the test, into the desk's folder "drive".
class RecorderProcess : public Process {
 public:
  explicit RecorderProcess(const Desk& desk, const std::string& command = "record")
      : Process(
            {"/bin/sh", "-c",
             "exec " ODOMD_BIN_DIR "/odom " + command + " --wait 10 --socket \"$0\" --out \"$1\"",
             desk.file("record.sock"), desk.file("drive")},
            desk.file("record.txt"), desk.file("record.txt")),
        desk_(desk) {}
  [[nodiscard]] bool holds(const std::string& folder, int ticks) const {
    return lines(folder + "/beat.csv") > ticks + 1;
  }
  [[nodiscard]] std::ptrdiff_t lines(const std::string& file) const {
    const std::string text = desk_.read(file);
    return std::count(text.begin(), text.end(), '\n');
  }

 private:
  const Desk& desk_;
};

class OdomdRecord : public ::testing::Test {
 protected:
  /// Two replays are bit-identical.
  void expect_bit_identical(const std::string& folder) const {
    for (int i = 0; i < 2; ++i) {
      EXPECT_EQ(desk_.odom("replay --recording " + folder + " --verify --out again.csv", "v.txt"),
                0)
          << desk_.read("v.txt") << desk_.read("stderr");
      EXPECT_THAT(desk_.read("v.txt"), HasSubstr("bit-identical to what was published"));
      EXPECT_EQ(desk_.read("again.csv"), desk_.read(folder + "/pose.csv"));
    }
  }
  void send_camera_poses() const {
    std::string rows = "t_arrival,t_capture,x,y,yaw,sigma_x,sigma_y,sigma_yaw\n";
    for (int i = 0; i < 30; ++i) {
      const double t = 0.033 * i;
      rows += fmt::format("{:.3f},{:.3f},{:.3f},2.01,0.001,0.05,0.05,0.05\n", t + 0.04, t, 1.0 + t);
    }
    desk_.write("camera.csv", rows);
    EXPECT_EQ(desk_.odom("camera send --socket camera.sock --from-now --log camera.csv", "c.txt"),
              0)
        << desk_.read("c.txt");
  }
  Desk desk_;
};

TEST_F(OdomdRecord, ReplaysADriveBitIdentically) {
  DaemonProcess odomd(desk_, {});
  RecorderProcess recorder(desk_, "record --once");
  ASSERT_TRUE(eventually([&] { return recorder.holds("drive", 1); })) << desk_.read("record.txt");
  odomd.feed(straight_drive(5.0, 1.0));
  send_camera_poses();
  ASSERT_TRUE(eventually([&] {
    return recorder.holds("drive", 300) && recorder.lines("drive/camera.csv") > 20 &&
           recorder.lines("drive/can.log") > 300;
  })) << desk_.read("record.txt");
  EXPECT_EQ(odomd.end_by(SIGTERM), 0);
  EXPECT_EQ(recorder.wait(), 0) << desk_.read("record.txt");
  EXPECT_THAT(desk_.read("record.txt"), HasSubstr("; odomd has ended"));
  EXPECT_THAT(desk_.read("drive/info.json"), HasSubstr("\"end\": \"odomd has ended\""));
  expect_bit_identical("drive");
}

TEST_F(OdomdRecord, StartsDuringADriveAndStopsOnSigint) {
  desk_.write("drive.log", straight_drive(30.0, 1.5));
  DaemonProcess odomd(desk_, {"--can", desk_.file("drive.log"), "--model", "kinematic"});
  desk_.await_status([](auto& now) { return now["beat"]["ticks"] > 200; });
  RecorderProcess recorder(desk_);
  ASSERT_TRUE(eventually([&] { return recorder.holds("drive", 200); })) << desk_.read("record.txt");
  recorder.signal(SIGINT);
  EXPECT_EQ(recorder.wait(), 0) << desk_.read("record.txt");
  EXPECT_THAT(desk_.read("drive/info.json"), HasSubstr("\"model\": \"kinematic\""));
  expect_bit_identical("drive");
  EXPECT_TRUE(desk_.logs("ticks: the recorder disconnected"));
  // Further recordings of the same daemon, each directly after the previous one.
  for (const char* folder : {"drive2", "drive3"}) {
    EXPECT_EQ(
        desk_.odom(fmt::format("record --socket record.sock --duration 0.3 --out {}/", folder),
                   "r.txt"),
        0);
    EXPECT_THAT(desk_.read("r.txt"), HasSubstr("the recorder was stopped"));
  }
  expect_bit_identical("drive2");
  expect_bit_identical("drive3");
}

TEST_F(OdomdRecord, ContinuesInAnotherFolderAfterARestartOfTheDaemon) {
  auto odomd = std::make_unique<DaemonProcess>(desk_, std::vector<std::string>{});
  RecorderProcess recorder(desk_);
  odomd->feed(straight_drive(5.0, 1.0));
  ASSERT_TRUE(eventually([&] { return recorder.holds("drive", 100); })) << desk_.read("record.txt");
  EXPECT_EQ(odomd->end_by(SIGKILL), 128 + SIGKILL);
  odomd = std::make_unique<DaemonProcess>(desk_, std::vector<std::string>{});
  odomd->feed(straight_drive(5.0, 1.0));
  ASSERT_TRUE(eventually([&] { return recorder.holds("drive-2", 100); }))
      << desk_.read("record.txt") << desk_.read("stderr");
  recorder.signal(SIGTERM);
  EXPECT_EQ(recorder.wait(), 0);
  EXPECT_THAT(desk_.read("record.txt"), HasSubstr("; odomd went away"));
  expect_bit_identical("drive");
  expect_bit_identical("drive-2");
}

TEST_F(OdomdRecord, ReportsTheEndToARecorderThatFallsBehind) {
  // 24,000 frames/s fill the rings in less than 2 s; then the recording ends with the last complete
  // tick. The log is long enough for a recorder that starts late.
  std::string log;
  for (int ms = 0; ms < 20'000; ++ms)
    for (int n = 0; n < 24; ++n)
      log += fmt::format("({}.{:06}) can0 100#E8030000\n", 1'700'000'000 + ms / 1000,
                         ms % 1000 * 1000 + n * 40);
  desk_.write("full.log", log);
  RecorderProcess recorder(desk_);
  DaemonProcess odomd(desk_, {"--can", desk_.file("full.log")});
  ASSERT_TRUE(eventually([&] { return recorder.holds("drive", 50); })) << desk_.read("record.txt");
  recorder.signal(SIGSTOP);
  const int at_stop = desk_.await_status()["can"][0]["received"];
  // After SIGCONT the recorder still reads what the rings and sockets hold.
  desk_.await_status([&](auto& now) { return now["can"][0]["received"] > at_stop + 50'000; });
  recorder.signal(SIGCONT);
  ASSERT_TRUE(eventually([&] { return recorder.holds("drive-2", 20); }))
      << desk_.read("record.txt") << desk_.read("stderr");
  recorder.signal(SIGKILL);
  EXPECT_EQ(recorder.wait(), 128 + SIGKILL);
  EXPECT_THAT(desk_.read("record.txt"), HasSubstr("; the recorder did not keep up"));
  expect_bit_identical("drive");
  expect_bit_identical("drive-2");
}

TEST_F(OdomdRecord, RefusesASecondRecorder) {
  DaemonProcess odomd(desk_, {});
  RecorderProcess recorder(desk_);
  ASSERT_TRUE(eventually([&] { return recorder.holds("drive", 1); })) << desk_.read("record.txt");
  EXPECT_EQ(desk_.odom("record --socket record.sock --out other", "r.txt"), 1);
  EXPECT_THAT(desk_.read("r.txt"), HasSubstr("odomd is already being recorded (by pid "));
  EXPECT_FALSE(std::filesystem::exists(desk_.file("other")));
  EXPECT_EQ(desk_.odom("record --socket record.sock --out drive", "r.txt"), 2);
  EXPECT_THAT(desk_.read("r.txt"), HasSubstr("drive: exists already; name another folder"));
}

}  // namespace
}  // namespace odomd::testing::odomd_record_test
