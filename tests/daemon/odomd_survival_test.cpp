// Events that a running odomd survives, and those that end it, with the line and exit status.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "daemon_process.hpp"
#include "shm_api/layout/segment.h"

namespace odomd::testing::odomd_survival_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

struct CloseClient {
  void operator()(odom_client* client) const { odom_close(client); }
};
using Client = std::unique_ptr<odom_client, CloseClient>;

class OdomdSurvival : public ::testing::Test {
 protected:
  Client open_client() {
    odom_client* client = nullptr;
    EXPECT_TRUE(eventually([&] { return odom_open(desk_.segment().c_str(), &client) == ODOM_OK; }))
        << desk_.read("stderr");
    return Client(client);
  }
  static bool next_pose(const Client& client, odom_pose& pose) {
    return odom_wait(client.get(), &pose, sizeof pose, -1) == ODOM_OK;
  }
  static std::uint64_t instance_of(const Client& client) {
    odom_info info{};
    odom_get_info(client.get(), &info, sizeof info);
    return info.instance_id;
  }
  bool is_logged(const std::string& text) {
    return eventually([&] { return desk_.read("stderr").find(text) != std::string::npos; });
  }
  int status_of(const std::vector<std::string>& arguments) {
    desk_.write("stderr", "");
    return DaemonProcess(desk_, arguments).wait();
  }

  Desk desk_;
};

// Signals -----------------------------------------------------------------------------------------

TEST_F(OdomdSurvival, NoSignalButTermAndIntAndFaultsEndsIt) {
  DaemonProcess odomd(desk_, {});
  const Client client = open_client();
  odom_pose pose{};
  ASSERT_TRUE(next_pose(client, pose));
  const std::vector<int> others{SIGKILL, SIGTERM, SIGINT, SIGSTOP, SIGTSTP, SIGTTIN, SIGTTOU,
                                SIGSEGV, SIGBUS,  SIGFPE, SIGILL,  SIGTRAP, SIGABRT, SIGSYS};
  for (int signal = 1; signal <= SIGRTMAX; ++signal) {
    if (std::find(others.begin(), others.end(), signal) != others.end()) continue;
    odomd.signal(signal);
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(next_pose(client, pose)) << "signal " << signal;
  }
  odomd.signal(SIGTERM);
  EXPECT_EQ(odomd.wait(), 0);
}

// Exit statuses, as odomd(8) has them
// ---------------------------------------------------------------

TEST_F(OdomdSurvival, EndsWithOneWhereItCouldNotRun) {
  const DaemonProcess first(desk_, {});
  const Client client = open_client();
  EXPECT_EQ(status_of({}), 1) << "a second one";
  EXPECT_THAT(desk_.read("stderr"),
              HasSubstr("process " + std::to_string(first.pid()) + " publishes there already"));
  const std::string elsewhere = desk_.file("elsewhere");
  EXPECT_EQ(status_of({"--shm", elsewhere}), 1) << "its sockets are the first one's";
  EXPECT_THAT(desk_.read("stderr"), HasSubstr("another program is listening there"));
  desk_.write("precious", "years of work");
  EXPECT_EQ(status_of({"--shm", desk_.file("precious")}), 1);
  EXPECT_EQ(status_of({"--shm", desk_.file("nowhere/pose")}), 1);
  EXPECT_EQ(status_of({"--shm", elsewhere, "--camera-socket", desk_.file("precious")}), 1);
  EXPECT_EQ(status_of({"--shm", elsewhere, "--camera-socket", "/nowhere/at/all.sock"}), 1);
  EXPECT_EQ(desk_.read("precious"), "years of work");
}

TEST_F(OdomdSurvival, EndsWithTwoWhereItWasAskedForNonsense) {
  EXPECT_EQ(status_of({"--nonsense"}), 2);
  EXPECT_EQ(status_of({"--shm", "/."}), 2);
  EXPECT_EQ(status_of({"--shm", desk_.file(std::string(300, 'a'))}), 2);
  EXPECT_EQ(status_of({"--can", "/nowhere/drive.log"}), 2);
  EXPECT_EQ(status_of({"--camera-socket", desk_.file(std::string(120, 'a'))}), 2);
  EXPECT_EQ(status_of({"--readers", "no-such-group"}), 2);
  desk_.write("car.dbc", "BO_ what is this\n");
  EXPECT_EQ(status_of({}), 2);
}

TEST_F(OdomdSurvival, EndsWithZeroWhereItIsDone) {
  EXPECT_EQ(status_of({"--check"}), 0);
  EXPECT_EQ(status_of({"--help"}), 0);
  desk_.write("drive.log", straight_drive(0.1, 1.0));
  EXPECT_EQ(status_of({"--can", desk_.file("drive.log"), "--exit-at-end"}), 0);
}

TEST_F(OdomdSurvival, ACheckRefusesAGroupThatAStartWouldRefuse) {
  const std::string car = desk_.read("car.toml");
  const auto refusal = [&](const std::string& after, const std::string& line,
                           std::vector<std::string> arguments) {
    std::string text = car;
    if (!line.empty()) text.insert(text.find(after) + after.size(), line);
    desk_.write("car.toml", text);
    const int started = status_of(arguments);
    arguments.push_back("--check");
    EXPECT_EQ(status_of(arguments), 2);
    EXPECT_EQ(started, 2);
    return desk_.read("stderr");
  };
  const std::string what = "there is no group \"nosuch\" on this machine";
  EXPECT_THAT(refusal("[shm]\n", "group = \"nosuch\"\n", {}),
              HasSubstr("car.toml: [shm] group: " + what));
  EXPECT_THAT(refusal("[camera]\n", "socket_group = \"nosuch\"\n", {}),
              HasSubstr("car.toml: [camera] socket_group: " + what));
  EXPECT_THAT(refusal("[status]\n", "socket_group = \"nosuch\"\n", {}),
              HasSubstr("car.toml: [status] socket_group: " + what));
  EXPECT_THAT(refusal("", "", {"--readers", "nosuch"}), HasSubstr("--readers: " + what));
  EXPECT_THAT(refusal("", "", {"--camera-senders", "nosuch"}),
              HasSubstr("--camera-senders: " + what));
}

// The segment under the daemon
// ------------------------------------------------------------------------

TEST_F(OdomdSurvival, MakesARemovedSegmentAgainAndReadersGoOverToIt) {
  DaemonProcess odomd(desk_, {});
  const Client client = open_client();
  odomd.feed(straight_drive(5.0, 1.0));
  odom_pose pose{};
  ASSERT_TRUE(eventually([&] { return next_pose(client, pose) && pose.x > 1.05; }));
  const std::uint64_t first = instance_of(client);
  const odom_pose before = pose;

  ASSERT_EQ(::unlink(desk_.segment().c_str()), 0);
  ASSERT_TRUE(is_logged(
      "the segment was removed or replaced while odomd was running; it has been recreated"));
  const Client late = open_client();
  EXPECT_TRUE(next_pose(late, pose));
  EXPECT_GT(pose.tick, before.tick);
  EXPECT_GT(pose.x, before.x);
  EXPECT_EQ(pose.reset_count, before.reset_count) << "the pose went on";
  ASSERT_TRUE(eventually(
      [&] { return next_pose(client, pose) && instance_of(client) == instance_of(late); }));
  const std::uint64_t second = instance_of(client);
  EXPECT_NE(second, first);
  odom_info info{};
  ASSERT_EQ(odom_get_info(late.get(), &info, sizeof info), ODOM_OK);
  EXPECT_EQ(pose.time_ns, info.first_tick_ns + static_cast<std::int64_t>(pose.tick) * 5'000'000);

  // Once more: the old ones are released.
  ASSERT_EQ(::unlink(desk_.segment().c_str()), 0);
  ASSERT_TRUE(eventually([&] { return next_pose(client, pose) && instance_of(client) != second; }));

  odomd.signal(SIGTERM);
  EXPECT_EQ(odomd.wait(), 0) << desk_.read("stderr");
  ASSERT_TRUE(
      eventually([&] { return odom_latest(client.get(), &pose, sizeof pose) == ODOM_STALE; }));
  odom_beat beat{};
  ASSERT_EQ(odom_get_beat(client.get(), &beat, sizeof beat), ODOM_STALE);
  EXPECT_EQ(beat.ticks + beat.missed, pose.tick) << "no tick was lost on the way";
}

TEST_F(OdomdSurvival, IsTheOnlyWriterWhateverIsRemoved) {
  DaemonProcess first(desk_, {});
  const Client client = open_client();
  odom_pose pose{};
  ASSERT_TRUE(next_pose(client, pose));
  for (const auto& gone : {std::vector<std::string>{desk_.segment() + ".lock"},
                           std::vector<std::string>{desk_.segment(), desk_.segment() + ".lock"}}) {
    for (const std::string& file : gone) ASSERT_EQ(::unlink(file.c_str()), 0);
    EXPECT_EQ(status_of({"--camera-socket", desk_.file("c2"), "--status-socket", desk_.file("s2")}),
              1);
    EXPECT_THAT(desk_.read("stderr"),
                HasSubstr("process " + std::to_string(first.pid()) + " publishes there already"));
    ASSERT_TRUE(eventually([&] {
      return std::filesystem::exists(desk_.segment()) &&
             std::filesystem::exists(desk_.segment() + ".lock");
    }));
    EXPECT_TRUE(is_logged("pose.lock was removed while odomd was running; it has been recreated") ||
                is_logged("it has been recreated"));
    ASSERT_TRUE(next_pose(open_client(), pose));
  }
  first.signal(SIGTERM);
  EXPECT_EQ(first.wait(), 0);
}

TEST_F(OdomdSurvival, SaysWhyItCannotMakeItsSegmentAgainAndGoesOn) {
  DaemonProcess odomd(desk_, {});
  const Client client = open_client();
  ASSERT_EQ(::unlink(desk_.segment().c_str()), 0);
  desk_.write("pose", "years of work, and no segment");
  ASSERT_TRUE(
      is_logged("cannot be recreated: " + desk_.segment() + ": is a file, not a segment of odomd"));
  EXPECT_EQ(desk_.read("pose"), "years of work, and no segment");
  odom_pose pose{};
  EXPECT_TRUE(next_pose(client, pose)) << "who has the old one goes on";
  ASSERT_EQ(::unlink(desk_.segment().c_str()), 0);
  ASSERT_TRUE(is_logged("it has been recreated"));
  EXPECT_TRUE(next_pose(open_client(), pose));
}

TEST_F(OdomdSurvival, ATruncatedSegmentEndsItWithOneLineAndASuccessorStarts) {
  for (const off_t size : {0, 8, 4096}) {
    desk_.write("stderr", "");
    DaemonProcess odomd(desk_, {});
    odom_pose pose{};
    {
      const Client client = open_client();
      ASSERT_TRUE(eventually([&] { return next_pose(client, pose); }));
    }
    ASSERT_EQ(::truncate(desk_.segment().c_str(), size), 0);
    EXPECT_EQ(odomd.wait(), 1) << size;
    EXPECT_THAT(desk_.read("stderr"),
                HasSubstr("odomd: the segment was truncated while it was in use (SIGBUS)"));
  }
  const DaemonProcess successor(desk_, {});
  odom_pose pose{};
  EXPECT_TRUE(eventually([&] { return next_pose(open_client(), pose); })) << desk_.read("stderr");
}

TEST_F(OdomdSurvival, AReaderOfATruncatedSegmentEndsWithOneLine) {
  DaemonProcess odomd(desk_, {});
  ASSERT_TRUE(open_client());
  odomd.feed(straight_drive(5.0, 1.0));
  const std::string command = "timeout 30 " ODOMD_BIN_DIR "/odom pose --follow --shm " +
                              desk_.segment() + " > " + desk_.file("poses").string() + " 2> " +
                              desk_.file("reader").string() + "; echo $? > " +
                              desk_.file("ended").string();
  FILE* const shell = ::popen(command.c_str(), "w");
  ASSERT_NE(shell, nullptr);
  ASSERT_TRUE(eventually([&] { return !desk_.read("poses").empty(); })) << desk_.read("reader");
  odomd.signal(SIGSTOP);  // so that only the reader accesses it
  ASSERT_EQ(::truncate(desk_.segment().c_str(), 0), 0);
  EXPECT_TRUE(eventually([&] { return desk_.read("ended") == "1\n"; })) << desk_.read("ended");
  ::pclose(shell);
  EXPECT_THAT(desk_.read("reader"),
              HasSubstr("odom: the segment was truncated while it was in use (SIGBUS)"));
}

// Its sockets
// ------------------------------------------------------------------------------------------

TEST_F(OdomdSurvival, MakesRemovedSocketsAgain) {
  const DaemonProcess odomd(desk_, {});
  ASSERT_TRUE(open_client());
  for (const std::string name : {"camera.sock", "status.sock", "record.sock"}) {
    ASSERT_TRUE(eventually([&] { return ::unlink(desk_.file(name).c_str()) == 0; })) << name;
    EXPECT_TRUE(is_logged(name + ": the socket was removed or replaced while odomd was running"))
        << name;
    EXPECT_TRUE(std::filesystem::is_socket(desk_.file(name))) << name;
  }
  EXPECT_FALSE(desk_.status().is_null());
  odom_camera* camera = nullptr;
  EXPECT_EQ(odom_camera_open(desk_.file("camera.sock").c_str(), &camera), 0);
  odom_camera_close(camera);
}

TEST_F(OdomdSurvival, IdleCamerasDoNotLockTheCameraOut) {
  const DaemonProcess odomd(desk_, {});
  const Client client = open_client();
  std::vector<odom_camera*> idle(4);
  for (odom_camera*& one : idle)
    ASSERT_EQ(odom_camera_open(desk_.file("camera.sock").c_str(), &one), 0);
  const auto send = [&] {
    const std::string command = ODOMD_BIN_DIR "/odom camera send --pose 1,2,0 --socket " +
                                desk_.file("camera.sock").string() + " 2> " +
                                desk_.file("sent").string();
    return WEXITSTATUS(std::system(command.c_str()));
  };
  EXPECT_EQ(send(), 1);
  EXPECT_THAT(desk_.read("sent"), HasSubstr("refused: odomd has as many camera connections"));
  odom_pose pose{};
  EXPECT_TRUE(eventually([&] {
    return next_pose(client, pose) && (pose.conditions & ODOM_COND_CAMERA_REFUSED) != 0;
  }));
  EXPECT_TRUE(eventually([&] { return send() == 0; })) << desk_.read("sent");
  EXPECT_EQ(desk_.status()["camera"]["messages"], 1);
  EXPECT_TRUE(is_logged("in place of one that sent no valid pose for 2 s"));
  for (odom_camera* one : idle) odom_camera_close(one);
}

// A predecessor's segment
// -----------------------------------------------------------------------------

TEST_F(OdomdSurvival, DoesNotGoOnFromADamagedPredecessor) {
  {
    DaemonProcess first(desk_, {});
    const Client client = open_client();
    first.feed(straight_drive(1.0, 1.0));
    odom_pose pose{};
    ASSERT_TRUE(eventually([&] { return next_pose(client, pose) && pose.x > 1.2; }));
    first.signal(SIGKILL);
    EXPECT_EQ(first.wait(), -1);
    const std::uint64_t slot = pose.tick % 1024;
    // Its words and those of some later ticks, published between the read and the kill.
    std::fstream file(desk_.segment(), std::ios::in | std::ios::out | std::ios::binary);
    for (std::uint64_t i = slot; i < slot + 60; ++i) {
      file.seekp(static_cast<std::streamoff>(
          ODOM_WORD_BYTES *
          (ODOM_SEGMENT_HEADER_WORDS + i % 1024 * ODOM_SLOT_WORDS + ODOM_SLOT_POSE + 2)));
      const double x = 7.0;
      file.write(reinterpret_cast<const char*>(&x), sizeof x);
    }
  }
  desk_.write("stderr", "");
  const DaemonProcess second(desk_, {});
  EXPECT_TRUE(is_logged("cannot resume from the last pose: it is damaged"));
  odom_pose pose{};
  ASSERT_TRUE(next_pose(open_client(), pose));
  EXPECT_EQ(pose.x, 1.0) << "as the configuration says";
  EXPECT_THAT(desk_.read("stderr"), Not(HasSubstr("resuming")));
}

}  // namespace
}  // namespace odomd::testing::odomd_survival_test
