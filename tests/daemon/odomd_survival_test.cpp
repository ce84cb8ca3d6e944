// Events that a running odomd survives, and events and mistakes that end it, with message and exit
// status.
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>

#include "daemon_process.hpp"
#include "shm_api/layout/segment.h"

namespace odomd::testing::odomd_survival_test {
namespace {

class OdomdSurvival : public ::testing::Test {
 protected:
  static std::uint64_t instance_of(const Client& client) {
    odom_info info{};
    odom_get_info(client.get(), &info, sizeof info);
    return info.instance_id;
  }
  int status_of(const std::vector<std::string>& arguments) {
    desk_.write("stderr", "");
    return DaemonProcess(desk_, arguments).wait();
  }
  /// The only line on standard error of a daemon that must end with status 2.
  std::string error_of(const std::vector<std::string>& arguments) {
    EXPECT_EQ(status_of(arguments), 2);
    auto errors = desk_.read("stderr");
    EXPECT_EQ(errors.find('\n'), errors.size() - 1) << errors;
    return errors;
  }

  Desk desk_;
};

// Signals -----------------------------------------------------------------------------------------

TEST_F(OdomdSurvival, IgnoresAllSignalsButTermIntAndFaults) {
  DaemonProcess odomd(desk_, {});
  const Client client = open_client(desk_);
  odom_pose pose = await_pose(client);
  const std::vector<int> others{SIGKILL, SIGTERM, SIGINT, SIGSTOP, SIGTSTP, SIGTTIN, SIGTTOU,
                                SIGSEGV, SIGBUS,  SIGFPE, SIGILL,  SIGTRAP, SIGABRT, SIGSYS};
  for (int signal = 1; signal <= SIGRTMAX; ++signal) {
    if (std::find(others.begin(), others.end(), signal) != others.end()) continue;
    odomd.signal(signal);
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(next_pose(client, pose)) << "signal " << signal;
  }
  EXPECT_EQ(odomd.end_by(SIGTERM), 0);
}

// Exit statuses as documented in odomd(8)

TEST_F(OdomdSurvival, ExitsWith1IfItCannotRun) {
  const DaemonProcess first(desk_, {});
  const Client client = open_client(desk_);
  const std::string elsewhere = desk_.file("elsewhere"), precious = desk_.file("precious");
  desk_.write("precious", "years of work");
  const std::pair<std::vector<std::string>, std::string> cases[]{
      {{}, desk_.segment() + ": process " + std::to_string(first.pid()) + " publishes there"},
      {{"--shm", elsewhere}, "another program is listening there"},
      {{"--shm", precious}, precious},
      {{"--shm", desk_.file("nowhere/pose")}, "nowhere: no such directory"},
      {{"--shm", elsewhere, "--camera-socket", precious}, precious},
      {{"--shm", elsewhere, "--camera-socket", "/nowhere/at/all.sock"}, "/nowhere/at"}};
  for (const auto& [arguments, says] : cases) {
    EXPECT_EQ(status_of(arguments), 1) << says;
    EXPECT_THAT(desk_.read("stderr"), AllOf(HasSubstr("odomd: "), HasSubstr(says)));
  }
  EXPECT_EQ(desk_.read("precious"), "years of work");
  await_pose(client);
  EXPECT_FALSE(desk_.status().is_null());
}

TEST_F(OdomdSurvival, CheckRefusesAGroupThatAStartWouldRefuse) {
  const std::string car = desk_.read("car.toml");
  const std::pair<std::string, std::vector<std::string>> cases[]{
      {"[shm] group", {}},
      {"[camera] socket_group", {}},
      {"[status] socket_group", {}},
      {"--readers", {"--readers", "nosuch"}},
      {"--camera-senders", {"--camera-senders", "nosuch"}}};
  for (const auto& [where, options] : cases) {
    std::string text = car;
    if (const auto key = where.find(' '); key != std::string::npos)
      text.insert(text.find(where.substr(0, key)) + key, '\n' + where.substr(key) + " = 'nosuch'");
    desk_.write("car.toml", text);
    EXPECT_EQ(status_of(options), 2) << where;
    std::vector<std::string> check = options;
    check.push_back("--check");
    EXPECT_EQ(status_of(check), 2) << where;
    EXPECT_THAT(desk_.read("stderr"),
                HasSubstr(where + ": there is no group \"nosuch\" on this machine"));
  }
}

// A segment that disappears or changes

TEST_F(OdomdSurvival, RecreatesARemovedSegmentAndReadersSwitchToIt) {
  DaemonProcess odomd(desk_, {});
  const Client client = open_client(desk_);
  odomd.feed(straight_drive(5.0, 1.0));
  odom_pose pose = await_pose(client, [](const odom_pose& p) { return p.x > 1.05; });
  const std::uint64_t first = instance_of(client);
  const odom_pose before = pose;

  ASSERT_EQ(::unlink(desk_.segment().c_str()), 0);
  ASSERT_TRUE(desk_.logs(
      "the segment was removed or replaced while odomd was running; it has been recreated"));
  const Client late = open_client(desk_);
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

  // Once more: the old segments were released.
  ASSERT_EQ(::unlink(desk_.segment().c_str()), 0);
  ASSERT_TRUE(eventually([&] { return next_pose(client, pose) && instance_of(client) != second; }));

  ASSERT_EQ(::unlink((desk_.segment() + ".lock").c_str()), 0);
  ASSERT_TRUE(desk_.logs("pose.lock was removed while odomd was running; it has been recreated"));

  EXPECT_EQ(odomd.end_by(SIGTERM), 0) << desk_.read("stderr");
  ASSERT_TRUE(becomes_stale(client, pose));
  odom_beat beat{};
  ASSERT_EQ(odom_get_beat(client.get(), &beat, sizeof beat), ODOM_STALE);
  EXPECT_EQ(beat.ticks + beat.missed, pose.tick) << "no tick was lost on the way";
}

TEST_F(OdomdSurvival, ReportsWhyItCannotRecreateItsSegmentAndContinues) {
  DaemonProcess odomd(desk_, {});
  const Client client = open_client(desk_);
  ASSERT_EQ(::unlink(desk_.segment().c_str()), 0);
  desk_.write("pose", "years of work, and no segment");
  ASSERT_TRUE(desk_.logs("cannot be recreated: " + desk_.segment() +
                         ": is a file, not a segment of odomd"));
  EXPECT_EQ(desk_.read("pose"), "years of work, and no segment");
  await_pose(client);  // a reader of the old segment continues
  ASSERT_EQ(::unlink(desk_.segment().c_str()), 0);
  ASSERT_TRUE(desk_.logs("it has been recreated"));
  await_pose(open_client(desk_));
}

TEST_F(OdomdSurvival, ExitsWithOneLineIfItsSegmentIsTruncatedAndASuccessorStarts) {
  for (const off_t size : {0, 8, 4096}) {
    desk_.write("stderr", "");
    DaemonProcess odomd(desk_, {});
    await_pose(open_client(desk_));
    ASSERT_EQ(::truncate(desk_.segment().c_str(), size), 0);
    EXPECT_EQ(odomd.wait(), 1) << size;
    EXPECT_THAT(desk_.read("stderr"),
                HasSubstr("odomd: the segment was truncated while it was in use (SIGBUS)"));
  }
  const DaemonProcess successor(desk_, {});
  await_pose(open_client(desk_));
}

TEST_F(OdomdSurvival, ReaderOfATruncatedSegmentExitsWithOneLine) {
  DaemonProcess odomd(desk_, {});
  ASSERT_TRUE(open_client(desk_));
  odomd.feed(straight_drive(5.0, 1.0));
  Process reader({ODOMD_BIN_DIR "/odom", "pose", "--follow", "--shm", desk_.segment()},
                 desk_.file("reader"), desk_.file("reader"));
  ASSERT_TRUE(eventually([&] { return !desk_.read("reader").empty(); }));
  odomd.signal(SIGSTOP);  // so that only the reader accesses the segment
  ASSERT_EQ(::truncate(desk_.segment().c_str(), 0), 0);
  EXPECT_EQ(reader.wait(), 1);
  EXPECT_THAT(desk_.read("reader"),
              HasSubstr("odom: the segment was truncated while it was in use (SIGBUS)"));
}

// Its sockets

TEST_F(OdomdSurvival, RecreatesRemovedSockets) {
  const DaemonProcess odomd(desk_, {});
  ASSERT_TRUE(open_client(desk_));
  for (const std::string name : {"camera.sock", "status.sock", "record.sock"}) {
    ASSERT_TRUE(eventually([&] { return ::unlink(desk_.file(name).c_str()) == 0; })) << name;
    EXPECT_TRUE(desk_.logs(name + ": the socket was removed or replaced while odomd was running"))
        << name;
    EXPECT_TRUE(std::filesystem::is_socket(desk_.file(name))) << name;
  }
  EXPECT_FALSE(desk_.status().is_null());
  EXPECT_TRUE(open_camera(desk_));
}

// A predecessor's segment

TEST_F(OdomdSurvival, DoesNotResumeFromADamagedPredecessor) {
  {
    DaemonProcess first(desk_, {});
    const Client client = open_client(desk_);
    first.feed(straight_drive(1.0, 1.0));
    const odom_pose pose = await_pose(client, [](const odom_pose& p) { return p.x > 1.2; });
    EXPECT_EQ(first.end_by(SIGKILL), 128 + SIGKILL);
    // Destroys this pose and some later ones, which were published between the read and the kill.
    std::fstream file(desk_.segment(), std::ios::in | std::ios::out | std::ios::binary);
    for (std::uint64_t tick = pose.tick; tick < pose.tick + 60; ++tick) {
      const std::uint64_t word = ODOM_SEGMENT_HEADER_WORDS + tick % 1024 * ODOM_SLOT_WORDS;
      file.seekp(static_cast<std::streamoff>(ODOM_WORD_BYTES * (word + ODOM_SLOT_POSE + 2)));
      const double x = 7.0;
      file.write(reinterpret_cast<const char*>(&x), sizeof x);
    }
  }
  desk_.write("stderr", "");
  const DaemonProcess second(desk_, {});
  EXPECT_TRUE(desk_.logs("cannot resume from the last pose: it is damaged"));
  const odom_pose pose = await_pose(open_client(desk_));
  EXPECT_EQ(pose.x, 1.0) << "as the configuration says";
  EXPECT_THAT(desk_.read("stderr"), Not(HasSubstr("resuming")));
}

// Mistakes are reported in one line, with exit status 2

TEST_F(OdomdSurvival, RefusesMistakesInTheFiles) {
  const std::string car = desk_.read("car.toml"), source = "source = \"-\"\n";
  std::string without = car;
  desk_.write("car.toml", without.erase(car.find(source), source.size()));
  EXPECT_THAT(error_of({}), HasSubstr("no CAN source is named; give --can can0"));
  desk_.write("car.toml", car);
  desk_.write("car.dbc", "BO_ what is this\n");
  EXPECT_THAT(error_of({}), HasSubstr("car.dbc:1: "));
}

TEST_F(OdomdSurvival, RefusesMistakesOnTheCommandLine) {
  std::pair<std::vector<std::string>, std::string> cases[]{
      {{"--can", "/nowhere/drive.log"}, "/nowhere/drive.log"},
      {{"--can", "-", "--can", "-"}, "--can: names \"-\" twice"},
      {{"--model", "particle"},
       "--model: \"particle\" is not a model of this version; the models are: kinematic"},
      {{"--initial", "1,2"}, "--initial: \"1,2\" is not a pose"},
      {{"--nonsense"}, "--nonsense"},
      {{"--shm", "odomd"}, "--shm: \"odomd\" must begin with a slash"},
      {{"--shm", "/."}, "/."},
      {{"--shm", desk_.file(std::string(300, 'a'))}, "aaa"},
      {{"--camera-socket", desk_.file(std::string(120, 'a'))}, "aaa"}};
  for (const auto& [arguments, says] : cases) EXPECT_THAT(error_of(arguments), HasSubstr(says));
  for (const std::string option : {"--shm", "--can", "--camera-socket", "--status-socket",
                                   "--runtime-directory", "--readers", "--initial", "--model"})
    EXPECT_THAT(error_of({option, ""}), HasSubstr(option + ": is empty; give a value"));
}

TEST_F(OdomdSurvival, RefusesTwoFilesWithOnePathInAnySpelling) {
  const std::string camera = desk_.file("camera.sock"), status = desk_.file("status.sock");
  std::filesystem::create_directory_symlink(desk_.file("."), desk_.file("link"));
  for (const auto& [option, path] : std::vector<std::pair<std::string, std::string>>{
           {"--shm", camera},
           {"--shm", desk_.file("link/./camera.sock")},
           {"--shm", desk_.file("record.sock")},
           {"--camera-socket", status},
           {"--status-socket", desk_.file("nowhere/../camera.sock")},
           {"--status-socket", desk_.segment()},
           {"--status-socket", desk_.segment() + ".lock"},
           {"--camera-socket", desk_.file("car.toml")},
           {"--shm", desk_.file("link/car.dbc")}})
    EXPECT_THAT(error_of({option, path}), HasSubstr(" have one path, ")) << option << path;
  const std::string car = desk_.read("car.toml");
  for (const char* log : {"car.toml", "link/car.dbc", "camera.sock", "pose"}) {
    desk_.write("car.toml", car + "[log]\nfile = \"" + log + "\"\n");
    EXPECT_THAT(error_of({}), HasSubstr(" have one path, ")) << log;
  }
  desk_.write("car.toml", car);
  EXPECT_EQ(desk_.read("car.dbc").find("VERSION"), 0U);
}

TEST_F(OdomdSurvival, RefusesAPipeOrADeviceForAFile) {
  const std::string car = desk_.read("car.toml");
  ASSERT_EQ(::mkfifo(desk_.file("pipe").c_str(), 0600), 0);
  for (const auto& [file, kind] : std::vector<std::pair<std::string, std::string>>{
           {"pipe", "is a named pipe; name a file"}, {"/dev/zero", "is a device; name a file"}}) {
    desk_.write("car.toml", car + "[log]\nfile = \"" + file + "\"\n");
    EXPECT_THAT(error_of({}), AllOf(HasSubstr("[log] file "), HasSubstr(kind)));
    std::string other = car;
    desk_.write("car.toml", other.replace(other.find("car.dbc"), 7, file));
    EXPECT_THAT(error_of({}), HasSubstr(kind));
    std::filesystem::remove(desk_.file("car.toml"));
    std::filesystem::create_symlink(file, desk_.file("car.toml"));
    EXPECT_THAT(error_of({}), HasSubstr("car.toml: " + kind));
    std::filesystem::remove(desk_.file("car.toml"));
  }
}

}  // namespace
}  // namespace odomd::testing::odomd_survival_test
