// The camera of a running daemon: its poses, its clock, and its connections.
#include <unistd.h>

#include <chrono>
#include <sstream>
#include <thread>

#include "daemon_process.hpp"
#include "tests/unix_socket.hpp"

namespace odomd::testing::odomd_camera_test {
namespace {

odom_camera_message camera_pose(const odom_pose& at) {
  odom_camera_message message{};
  message.clock = ODOM_CLOCK_MONOTONIC;
  message.capture_ns = at.time_ns;
  message.x = at.x + 0.01;
  message.y = at.y;
  message.yaw = at.yaw;
  message.sigma_x = message.sigma_y = 0.05;
  message.sigma_yaw = 0.05;
  return message;
}

/// A camera pose at the start position, whose log stamp is `after_ns` after the first frame.
odom_camera_message log_pose(std::int64_t after_ns) {
  odom_camera_message message{};
  message.clock = ODOM_CLOCK_LOG;
  message.capture_ns = 1'700'000'000'000'000'000 + after_ns;
  message.sigma_x = message.sigma_y = message.sigma_yaw = 0.5;
  return message;
}

class OdomdCamera : public ::testing::Test {
 protected:
  Desk desk_;
};

TEST_F(OdomdCamera, TakesCameraPosesAndCountsMalformedMessages) {
  DaemonProcess odomd(desk_, {});
  const Client client = open_client(desk_);
  odomd.feed(straight_drive(5.0, 1.0));
  odom_pose pose = await_pose(client, [](const odom_pose& p) { return p.vx > 0.9; });

  Camera camera = open_camera(desk_);
  const auto message = camera_pose(pose);
  ASSERT_EQ(odom_camera_send(camera.get(), &message), 0);
  odom_details details{};
  ASSERT_TRUE(eventually([&] {
    return odom_latest_details(client.get(), &pose, sizeof pose, &details, sizeof details) ==
               ODOM_OK &&
           details.camera_messages == 1;
  }));
  EXPECT_TRUE(next_pose(client, pose, [](const odom_pose& p) {
    return (p.health >> ODOM_SOURCE_CAMERA & 1U) != 0;
  })) << desk_.status().dump(1);

  FileDescriptor raw = connected_socket(desk_.file("camera.sock"), SOCK_SEQPACKET);
  ASSERT_EQ(::send(raw.get(), "rubbish", 7, MSG_NOSIGNAL), 7);
  auto status = desk_.await_status([](auto& now) { return now["camera"]["malformed"] == 1; });
  EXPECT_EQ(status["camera"]["messages"], 2);
  EXPECT_EQ(status["camera"]["connections"].size(), 2U);
  EXPECT_EQ(status["camera"]["connections"][0]["pid"], ::getpid());
  raw = {};
  camera.reset();
  desk_.await_status([](auto& now) { return now["camera"]["connections"].empty(); });
  EXPECT_TRUE(desk_.logs("a camera message was invalid: it is not 80 bytes"));
}

// The first line is late, and the poses are stamped 40 ms behind the log.
TEST_F(OdomdCamera, SynchronisesAPipeWhoseFirstLineWasLate) {
  using Clock = std::chrono::steady_clock;
  const DaemonProcess odomd(desk_, {"--model", "full"});
  const Camera camera = open_camera(desk_);
  const auto begin = Clock::now();
  std::this_thread::sleep_for(std::chrono::milliseconds(400));
  std::istringstream lines(straight_drive(12.0, 1.0));
  std::string line;
  long sent = 0;
  desk_.await_status([&](auto& status) {
    const std::int64_t gone_ns = std::chrono::nanoseconds(Clock::now() - begin).count();
    std::string text;
    for (; sent < 3 * gone_ns / 10'000'000 && std::getline(lines, line); ++sent)
      text += line + '\n';
    odomd.feed(text);
    odom_camera_message message = log_pose(gone_ns - 40'000'000);
    message.x = 1.0 + static_cast<double>(gone_ns) * 1e-9;
    message.y = 2.0;
    odom_camera_send(camera.get(), &message);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return status["sources"][ODOM_SOURCE_CAMERA]["verdicts"]["fused"].template get<int>() > 20;
  });
  EXPECT_THAT(desk_.read("stderr"), HasSubstr("earlier than before relative to their time stamps"));
}

TEST_F(OdomdCamera, WarnsOfPosesInTheFutureWithTheNewestOffset) {
  const DaemonProcess odomd(desk_, {});
  const Client client = open_client(desk_);
  const Camera camera = open_camera(desk_);
  odom_pose pose = await_pose(client);
  const auto send = [&](double ahead_s) {
    odom_camera_message message = camera_pose(pose);
    message.capture_ns += static_cast<std::int64_t>(ahead_s * 1e9);
    EXPECT_EQ(odom_camera_send(camera.get(), &message), 0);
  };
  for (int i = 0; i < 12; ++i) send(1000.0);
  send(-1000.0);
  const std::int64_t sent_ns = pose.time_ns;
  ASSERT_TRUE(next_pose(client, pose,
                        [=](const odom_pose& p) { return p.time_ns > sent_ns + 100'000'000; }));
  for (int i = 0; i < 30; ++i) send(1000.0);
  EXPECT_TRUE(desk_.logs("camera poses are all stamped in the future, the newest by 999."));
  EXPECT_THAT(desk_.read("stderr"), Not(HasSubstr("the newest by -")));
}

TEST_F(OdomdCamera, WarnsOfAPoseBeforeTheFirstFrameOfItsLog) {
  const DaemonProcess odomd(desk_, {});
  const Camera camera = open_camera(desk_);
  const odom_camera_message message = log_pose(0);
  EXPECT_EQ(odom_camera_send(camera.get(), &message), 0);
  EXPECT_TRUE(desk_.logs("no log is being played yet"));
}

TEST_F(OdomdCamera, InitialisesThePoseIfNoOtherIsGiven) {
  auto text = desk_.read("car.toml");
  const std::string initial = "[initial]\npose = [1.0, 2.0, 0.0]\n";
  desk_.write("car.toml", text.erase(text.find(initial), initial.size()));
  DaemonProcess odomd(desk_, {});
  const Client client = open_client(desk_);
  odomd.feed(straight_drive(5.0, 1.0));
  odom_pose pose = await_pose(client);
  ASSERT_TRUE(next_pose(client, pose));
  EXPECT_EQ(pose.mode, static_cast<std::uint32_t>(ODOM_INITIALISING));

  const Camera camera = open_camera(desk_);
  ASSERT_TRUE(next_pose(client, pose, [&](odom_pose seen) {
    if (seen.mode != ODOM_INITIALISING) return true;
    seen.x = 30.0;
    seen.y = 40.0;
    const auto message = camera_pose(seen);
    odom_camera_send(camera.get(), &message);
    return false;
  })) << desk_.status().dump(1);
  EXPECT_NEAR(pose.x, 30.0, 1.0);
  EXPECT_NEAR(pose.y, 40.0, 1.0);
}

TEST_F(OdomdCamera, IdleConnectionsDoNotLockItOut) {
  const DaemonProcess odomd(desk_, {});
  const Client client = open_client(desk_);
  std::vector<Camera> idle;
  while (idle.size() < 4) idle.push_back(open_camera(desk_));
  const auto send = [&] {
    return desk_.odom("camera send --pose 1,2,0 --socket camera.sock", "sent");
  };
  EXPECT_EQ(send(), 1);
  EXPECT_THAT(desk_.read("sent"), HasSubstr("refused: odomd has as many camera connections"));
  await_pose(client,
             [](const odom_pose& p) { return (p.conditions & ODOM_COND_CAMERA_REFUSED) != 0; });
  EXPECT_TRUE(eventually([&] { return send() == 0; })) << desk_.read("sent");
  EXPECT_EQ(desk_.status()["camera"]["messages"], 1);
  EXPECT_TRUE(desk_.logs("in place of one that sent no valid pose for 2 s"));
}

}  // namespace
}  // namespace odomd::testing::odomd_camera_test
