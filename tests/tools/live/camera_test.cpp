// odom camera send, to the test's own socket.
#include <poll.h>
#include <sys/socket.h>

#include <odom/odom.h>

#include <cerrno>
#include <thread>

#include "base/file_descriptor.hpp"
#include "tests/tools/own_daemon.hpp"
#include "tests/tools/scratch.hpp"

namespace odomd::tools::camera_test {
namespace {

class CameraSend : public ::testing::Test {
 protected:
  void listen() { socket_ = listening_socket(path_, SOCK_SEQPACKET | SOCK_NONBLOCK); }
  // Messages from the program, which has ended by now.
  const std::vector<odom_camera_message>& received() const { return messages_; }
  Outcome run(const std::string& arguments, const std::string& input = "") {
    const auto file = scratch_.write("in", input).string();
    messages_.clear();
    std::jthread daemon([this](const std::stop_token& stop) { read_poses(stop); });
    return run_shell("odom camera send --socket " + path_ + " " + arguments + " <" + file);
  }
  // Serves one connection after the other, like odomd.
  void read_poses(const std::stop_token& stop) {
    while (socket_ && !stop.stop_requested()) {
      pollfd wanted{socket_.get(), POLLIN, 0};
      if (::poll(&wanted, 1, 5) == 0) continue;
      const FileDescriptor connection{::accept(socket_.get(), nullptr, nullptr)};
      if (refusal_ != 0) {
        EXPECT_EQ(::send(connection.get(), &refusal_, sizeof refusal_, MSG_NOSIGNAL), 4);
        continue;
      }
      odom_camera_message message{};
      while (::recv(connection.get(), &message, sizeof message, 0) == sizeof message)
        messages_.push_back(message);
    }
  }

  const std::string header_ = "t_arrival,t_capture,x,y,yaw,sigma_x,sigma_y,sigma_yaw\n";
  Scratch scratch_;
  std::string path_ = scratch_.path("camera.sock").string();
  FileDescriptor socket_;
  std::int32_t refusal_ = 0;
  std::vector<odom_camera_message> messages_;
};

TEST_F(CameraSend, SendsOnePoseWithItsAge) {
  listen();
  const std::int64_t before = now_ns();
  const Outcome outcome = run("--pose 1.5,-2,0.25 --sigma 0.1,0.2,0.3 --age-ms 40");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const auto messages = received();
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_EQ(messages[0].magic, ODOM_CAMERA_MAGIC);
  EXPECT_EQ(messages[0].clock, ODOM_CLOCK_MONOTONIC);
  EXPECT_EQ(messages[0].x, 1.5);
  EXPECT_EQ(messages[0].y, -2.0);
  EXPECT_EQ(messages[0].yaw, 0.25);
  EXPECT_EQ(messages[0].sigma_yaw, 0.3);
  EXPECT_GE(messages[0].capture_ns, before - 40'000'000);
  EXPECT_LE(messages[0].capture_ns, now_ns() - 40'000'000);
}

TEST_F(CameraSend, SendsRowsOfStandardInputOnTheirClock) {
  listen();
  const Outcome outcome =
      run("--clock realtime", header_ + "9,8.5,1,2,3,1,1,1\n10,9.000000001,4,5,6,1,1,1\n11,10,1");
  EXPECT_THAT(outcome, Ends(0, HasSubstr("warning: standard input:4: the last line is cut off")));
  EXPECT_THAT(outcome.err, HasSubstr("2 poses sent"));
  const auto messages = received();
  ASSERT_EQ(messages.size(), 2U);
  EXPECT_EQ(messages[1].clock, ODOM_CLOCK_REALTIME);
  EXPECT_EQ(messages[1].capture_ns, 9'000'000'001);
  EXPECT_EQ(messages[1].sequence, messages[0].sequence + 1);
}

TEST_F(CameraSend, PlaysALogFromNowAtItsOwnPace) {
  listen();
  const auto log = scratch_.write("camera.csv", header_ +
                                                    "100,99.96,1,0,0,1,1,1\n"
                                                    "100.05,100.01,2,0,0,1,1,1\n");
  const std::int64_t before = now_ns();
  EXPECT_EQ(run("--from-now --log " + log.string()).status, 0);
  EXPECT_GE(now_ns() - before, 50'000'000);
  const auto messages = received();
  ASSERT_EQ(messages.size(), 2U);
  EXPECT_EQ(messages[1].capture_ns - messages[0].capture_ns, 50'000'000);
  EXPECT_GE(messages[0].capture_ns, before - 40'000'000);
}

TEST_F(CameraSend, PlaysALogInStepWithTheDaemons) {
  listen();
  SlowDaemon daemon{scratch_.path("pose").string()};
  daemon.play_log(1'000'000'000'000);
  const auto log = scratch_.write("camera.csv", header_ +
                                                    "990,989.9,1,0,0,1,1,1\n"
                                                    "1001.5,1001.45,2,0,0,1,1,1\n");
  EXPECT_THAT(run("--clock log --shm " + scratch_.path("pose").string() + " --log " + log.string()),
              Ends(0, HasSubstr("1 poses were due before the start")));
  const auto messages = received();
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_EQ(messages[0].clock, ODOM_CLOCK_LOG);
  EXPECT_EQ(messages[0].capture_ns, 1'001'450'000'000);
}

TEST_F(CameraSend, SaysThatItIsRefusedHoweverThePosesCome) {
  listen();
  const auto log = scratch_.write("camera.csv", header_ + "1,1,1,0,0,1,1,1\n2,1.1,2,0,0,1,1,1\n");
  const std::string rows = header_ + "1,1,0,0,0,1,1,1\n2,2,0,0,0,1,1,1\n";
  for (const auto& [reason, text] : {std::pair{-EBUSY, "as many camera connections as it takes"},
                                     std::pair{-EACCES, "not allowed; join the group"}}) {
    refusal_ = reason;
    for (const std::string& how : {std::string("--pose 1,2,3"), "--from-now --log " + log.string(),
                                   std::string("--clock realtime")})
      EXPECT_THAT(run(how, rows), Ends(1, AllOf(HasSubstr(path_ + ": "), HasSubstr(text)))) << how;
  }
}

TEST_F(CameraSend, SaysThatNobodyReadsThePose) {
  listen();
  const FileDescriptor stopped{::dup(socket_.get())};
  socket_ = {};  // nobody accepts
  EXPECT_THAT(run("--pose 1,2,3"), Ends(1, HasSubstr("does not take poses; is it stopped?")));
}

TEST_F(CameraSend, RefusesBadPosesAndRowsInOneLine) {
  listen();
  for (const std::string bad :
       {"--pose 1,2", "--pose 1,2,nan", "--pose 1,2,3 --sigma 0,1,1", "--pose 1,2,3 --age-ms inf",
        "--sigma 1,1,1", "--log /nonexistent.csv", "--log x.csv --clock realtime",
        "--pose 1,2,3 --log x.csv"})
    EXPECT_THAT(run(bad), Ends(2, ::testing::MatchesRegex("odom camera send: [^\n]*\n"))) << bad;
  EXPECT_THAT(run("", header_ + "1,1,0,0,0,1,-1,1\n"),
              Ends(2, HasSubstr("standard input:2: column \"sigma_y\"")));
}

}  // namespace
}  // namespace odomd::tools::camera_test
