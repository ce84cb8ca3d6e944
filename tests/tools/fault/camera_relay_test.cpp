// The camera's poses between two sockets: a camera sends, a fault acts, a daemon receives.
#include <gtest/gtest.h>
#include <sys/socket.h>

#include <odom/odom.hpp>

#include <chrono>
#include <optional>
#include <thread>

#include "tests/tools/scratch.hpp"
#include "tools/fault/live.hpp"

namespace odomd::fault::camera_relay_test {
namespace {

odom_camera_message message_at(double x) {
  odom_camera_message message{};
  message.clock = ODOM_CLOCK_REALTIME;
  message.capture_ns = 123'456'789;
  message.x = x;
  message.sigma_x = message.sigma_y = message.sigma_yaw = 0.01;
  return message;
}

// Stands for the daemon's end.
class Daemon {
 public:
  explicit Daemon(const std::filesystem::path& path)
      : socket_({.path = path, .type = daemon::SocketType::packets}) {}

  std::optional<odom_camera_message> receive() {
    if (!connection_) connection_ = socket_.accept();
    odom_camera_message message{};
    const ssize_t size = ::recv(connection_.get(), &message, sizeof message, MSG_DONTWAIT);
    if (size != sizeof message) return std::nullopt;
    return message;
  }

 private:
  daemon::LocalSocket socket_;
  FileDescriptor connection_;
};

TEST(CameraRelay, HandsPosesOnWithTheirFault) {
  const tools::Scratch scratch;
  Daemon daemon(scratch.path("daemon.sock"));
  const std::vector<Fault> faults{fault_of(parse_kind("camera.moved")),
                                  fault_of(parse_kind("camera.early"))};
  CameraRelay relay(scratch.path("fault.sock"), scratch.path("daemon.sock").string(), 0.0, faults,
                    0);
  odom::CameraSender camera;
  ASSERT_EQ(camera.open(scratch.path("fault.sock").c_str()), 0);
  ASSERT_EQ(camera.send(message_at(1.0)), 0);
  relay.pass_on(monotonic_ns());
  const auto received = daemon.receive();
  ASSERT_TRUE(received);
  EXPECT_NEAR(received->x, 1.5, 1e-12);
  EXPECT_EQ(received->clock, ODOM_CLOCK_REALTIME);
  EXPECT_EQ(received->capture_ns, 73'456'789);
  EXPECT_EQ(relay.sent(), 1U);
}

TEST(CameraRelay, DelayedPosesAreHeldBack) {
  const tools::Scratch scratch;
  Daemon daemon(scratch.path("daemon.sock"));
  const std::vector<Fault> faults{fault_of(parse_kind("camera.delayed"))};
  CameraRelay relay(scratch.path("fault.sock"), scratch.path("daemon.sock").string(), 0.0, faults,
                    0);
  odom::CameraSender camera;
  ASSERT_EQ(camera.open(scratch.path("fault.sock").c_str()), 0);
  ASSERT_EQ(camera.send(message_at(1.0)), 0);
  const std::int64_t now_ns = monotonic_ns();
  relay.pass_on(now_ns);
  EXPECT_FALSE(daemon.receive());
  relay.pass_on(now_ns + 99'000'000);
  EXPECT_FALSE(daemon.receive());
  relay.pass_on(now_ns + 100'000'000);
  EXPECT_TRUE(daemon.receive());
}

// A camera that goes and comes again, and one that talks nonsense.
TEST(CameraRelay, CamerasComeAndGo) {
  const tools::Scratch scratch;
  Daemon daemon(scratch.path("daemon.sock"));
  CameraRelay relay(scratch.path("fault.sock"), scratch.path("daemon.sock").string(), 0.0, {}, 0);
  for (int i = 0; i < 3; ++i) {
    odom::CameraSender camera;
    ASSERT_EQ(camera.open(scratch.path("fault.sock").c_str()), 0);
    ASSERT_EQ(camera.send(message_at(1.0)), 0);
    relay.pass_on(monotonic_ns());
    EXPECT_TRUE(daemon.receive());
  }
  odom::CameraSender wrong;
  ASSERT_EQ(wrong.open(scratch.path("fault.sock").c_str()), 0);
  odom_camera_message message = message_at(1.0);
  message.sigma_x = 1.0;
  ASSERT_EQ(wrong.send(message), 0);
  relay.pass_on(monotonic_ns());
  EXPECT_EQ(relay.received(), 4U);
  EXPECT_EQ(relay.malformed(), 0U);
}

TEST(CameraRelay, NobodyBehindItIsAnError) {
  const tools::Scratch scratch;
  EXPECT_NE(tools::message_of([&] {
              const CameraRelay relay(scratch.path("fault.sock"),
                                      scratch.path("daemon.sock").string(), 0.0, {}, 0);
            }).find("is odomd running"),
            std::string::npos);
}

}  // namespace
}  // namespace odomd::fault::camera_relay_test
