// The camera side of the socket: the bytes on the wire, and the behaviour without a daemon.
#include <sys/socket.h>
#include <unistd.h>
#include <cerrno>
#include <cstring>
#include <limits>

#include <odom/odom.hpp>

#include "tests/gtest.hpp"
#include "tests/shm_api/segment_fixture.hpp"
#include "tests/unix_socket.hpp"

namespace odomd::shm::testing::test_camera_sender {
namespace {

class Daemon {
 public:
  explicit Daemon(const std::string& path)
      : path_(path), listener_(listening_socket(path, SOCK_SEQPACKET)) {}
  ~Daemon() { unlink(path_.c_str()); }
  Daemon(const Daemon&) = delete;
  Daemon& operator=(const Daemon&) = delete;

  void accept_one() {
    connection_ = FileDescriptor(accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC));
  }
  void close_one() { connection_ = FileDescriptor(); }
  void refuse_one(std::int32_t reason) {
    accept_one();
    EXPECT_EQ(::send(connection_.get(), &reason, sizeof reason, MSG_NOSIGNAL), 4);
    close_one();
  }
  [[nodiscard]] odom_camera_message receive() const {
    std::array<char, 256> bytes{};
    EXPECT_EQ(recv(connection_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT), 80);
    odom_camera_message message{};
    std::memcpy(&message, bytes.data(), sizeof message);
    return message;
  }

 private:
  std::string path_;
  FileDescriptor listener_;
  FileDescriptor connection_;
};

odom_camera_message seen_pose() {
  return {.clock = ODOM_CLOCK_REALTIME,
          .capture_ns = 1'700'000'000'123'456'789,
          .x = 1.5,
          .y = -2.5,
          .yaw = 0.25,
          .sigma_x = 0.008,
          .sigma_y = 0.008,
          .sigma_yaw = 0.009};
}

class CameraSender : public ::testing::Test {
 protected:
  TemporaryDirectory directory;
  std::string path = directory.file("camera.sock");
  odom::CameraSender sender;
};

TEST_F(CameraSender, RefusalIsAnErrorOfTheNextCall) {
  Daemon daemon(path);
  for (const bool flushes : {true, false}) {
    ASSERT_EQ(sender.open(path.c_str()), 0);
    ASSERT_EQ(sender.send(seen_pose()), 0);
    EXPECT_EQ(sender.flush(0), -EAGAIN) << "nobody has read it";
    daemon.refuse_one(-EBUSY);
    EXPECT_EQ(flushes ? sender.flush(1'000'000'000) : sender.send(seen_pose()), -EBUSY);
    ASSERT_EQ(sender.send(seen_pose()), 0) << "on a new connection";
    daemon.accept_one();
    EXPECT_EQ(daemon.receive().x, 1.5);
    EXPECT_EQ(sender.flush(0), 0);
  }
}

TEST_F(CameraSender, ClosedConnectionOrRestartLosesNoPose) {
  for (const bool restarted : {false, true}) {
    odom::CameraSender idle;
    auto daemon = std::make_unique<Daemon>(path);
    ASSERT_EQ(idle.open(path.c_str()), 0);
    daemon->accept_one();
    daemon->close_one();
    if (restarted) {
      daemon.reset();
      daemon = std::make_unique<Daemon>(path);
    }
    ASSERT_EQ(idle.send(seen_pose()), 0);
    daemon->accept_one();
    const odom_camera_message received = daemon->receive();
    EXPECT_EQ(received.x, 1.5);
    EXPECT_EQ(received.sequence, 1U);
  }
}

TEST_F(CameraSender, APoseIsOneMessage) {
  Daemon daemon(path);
  ASSERT_EQ(sender.open(path.c_str()), 0);
  daemon.accept_one();
  ASSERT_EQ(sender.send(seen_pose()), 0);
  ASSERT_EQ(sender.send(seen_pose()), 0);
  odom_camera_message expected = seen_pose();
  std::memcpy(&expected.magic, "ODCM", 4);
  expected.version = 1;
  for (expected.sequence = 1; expected.sequence <= 2; ++expected.sequence)
    EXPECT_TRUE(is_same(daemon.receive(), expected)) << expected.sequence;
}

TEST_F(CameraSender, MissingDaemonIsAnError) {
  EXPECT_EQ(sender.open(path.c_str()), -ENOENT);
  EXPECT_EQ(sender.send(seen_pose()), -EINVAL);
  EXPECT_EQ(sender.open(std::string(200, 'x').c_str()), -ENAMETOOLONG);
  EXPECT_EQ(sender.open(""), -EINVAL);
}

TEST_F(CameraSender, ARestartedDaemonIsFoundAgain) {
  {
    Daemon daemon(path);
    ASSERT_EQ(sender.open(path.c_str()), 0);
    daemon.accept_one();
    ASSERT_EQ(sender.send(seen_pose()), 0);
  }
  EXPECT_EQ(sender.send(seen_pose()), -ENOENT);
  Daemon restarted(path);
  ASSERT_EQ(sender.send(seen_pose()), 0);
  restarted.accept_one();
  EXPECT_EQ(restarted.receive().sequence, 3U);
}

TEST_F(CameraSender, DaemonThatDoesNotReadBlocksNobody) {
  Daemon daemon(path);
  ASSERT_EQ(sender.open(path.c_str()), 0);
  int error = 0;
  for (int i = 0; i < 100'000 && error == 0; ++i) error = sender.send(seen_pose());
  EXPECT_EQ(error, -EAGAIN);
}

TEST_F(CameraSender, UnusablePosesAreNotSent) {
  Daemon daemon(path);
  ASSERT_EQ(sender.open(path.c_str()), 0);
  static constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  void (*const changes[])(odom_camera_message&){
      [](auto& m) { m.x = nan; },         [](auto& m) { m.y = nan; },
      [](auto& m) { m.yaw = nan; },       [](auto& m) { m.sigma_x = nan; },
      [](auto& m) { m.sigma_yaw = nan; }, [](auto& m) { m.sigma_y = 0.0; },
      [](auto& m) { m.clock = 3; }};
  for (const auto change : changes) {
    odom_camera_message message = seen_pose();
    change(message);
    EXPECT_EQ(sender.send(message), -EINVAL);
  }
}

}  // namespace
}  // namespace odomd::shm::testing::test_camera_sender
