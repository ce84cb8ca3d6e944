// The camera connections over real socket pairs: what the beat reads from them, and when they end.
#include "daemon/sockets/camera_door.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>

#include <array>
#include <memory>
#include <vector>

namespace odomd::daemon::camera_door_test {
namespace {

class CameraDoorTest : public testing::Test {
 protected:
  /// Connects a camera; its end.
  FileDescriptor connect(Peer peer = {1, 2}) {
    std::array<int, 2> ends{};
    EXPECT_EQ(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()), 0);
    FileDescriptor mine(ends[0]);
    admitted_ = door_.admit(FileDescriptor(ends[1]), peer);
    return mine;
  }

  static void send(const FileDescriptor& camera, std::int64_t capture_ns) {
    odom_camera_message message{};
    message.magic = ODOM_CAMERA_MAGIC;
    message.version = ODOM_CAMERA_VERSION;
    message.capture_ns = capture_ns;
    EXPECT_EQ(::send(camera.get(), &message, sizeof message, MSG_NOSIGNAL),
              static_cast<ssize_t>(sizeof message));
  }

  CameraDoor::Drained drain() { return door_.drain(poses_, {wall_, {}}, 77, *events_); }

  CameraDoor door_;
  std::unique_ptr<EventRing> events_ = std::make_unique<EventRing>();
  WallClock wall_;
  std::array<estimator::CameraPose, CameraDoor::max_poses> poses_{};
  bool admitted_ = false;
};

TEST_F(CameraDoorTest, ReadsNothingWhereNobodyIsConnected) {
  EXPECT_EQ(drain().poses, 0U);
}

TEST_F(CameraDoorTest, ReadsWhatEachConnectionSent) {
  const auto one = connect();
  const auto two = connect();
  send(one, 10);
  send(one, 11);
  send(two, 20);
  EXPECT_EQ(drain().poses, 3U);
  EXPECT_EQ(poses_[0].capture_ns, 10);
  EXPECT_EQ(poses_[0].arrival_ns, 77);
  EXPECT_EQ(poses_[1].capture_ns, 11);
  EXPECT_EQ(poses_[2].capture_ns, 20);
  EXPECT_EQ(drain().poses, 0U);
}

TEST_F(CameraDoorTest, LeavesAFloodForTheNextTicks) {
  const auto camera = connect();
  constexpr std::size_t sent = CameraDoor::max_messages_per_drain + 3;
  for (std::size_t i = 0; i < sent; ++i) send(camera, static_cast<std::int64_t>(i));
  EXPECT_EQ(drain().poses, CameraDoor::max_messages_per_drain);
  EXPECT_EQ(drain().poses, 3U);
  EXPECT_EQ(poses_[2].capture_ns, static_cast<std::int64_t>(sent - 1));
}

TEST_F(CameraDoorTest, CountsMalformedMessagesAndSaysWhy) {
  const auto camera = connect();
  const std::vector<char> rubbish(200, 'x');
  for (const std::size_t size : {std::size_t{1}, sizeof(odom_camera_message), rubbish.size()})
    EXPECT_GT(::send(camera.get(), rubbish.data(), size, MSG_NOSIGNAL), 0);
  send(camera, 5);
  const auto drained = drain();
  EXPECT_EQ(drained.poses, 1U);
  EXPECT_EQ(drained.malformed, 3U);
  EXPECT_EQ(poses_[0].capture_ns, 5);

  for (const auto cause : {MalformedCause::size, MalformedCause::magic, MalformedCause::size}) {
    const auto event = events_->next();
    ASSERT_TRUE(event.has_value());
    EXPECT_EQ(event->kind, EventKind::camera_malformed);
    EXPECT_EQ(event->a, static_cast<std::int64_t>(cause));
  }
  EXPECT_EQ(door_.connections()[0].messages, 4U);
  EXPECT_EQ(door_.connections()[0].malformed, 3U);
}

TEST_F(CameraDoorTest, ReadsTheLastMessagesOfACameraThatHasGone) {
  auto camera = connect();
  send(camera, 1);
  camera = {};
  EXPECT_EQ(drain().poses, 1U);
  EXPECT_EQ(events_->next()->kind, EventKind::camera_gone);
  EXPECT_FALSE(door_.connections()[0].open);
}

TEST_F(CameraDoorTest, HasRoomForFourAndForTheNextOnceOneHasGone) {
  std::vector<FileDescriptor> cameras;
  for (std::size_t i = 0; i < CameraDoor::max_connections; ++i) {
    cameras.push_back(connect());
    EXPECT_TRUE(admitted_);
  }
  {
    const auto fifth = connect();
    EXPECT_FALSE(admitted_);
  }
  send(cameras[2], 3);
  cameras[2] = {};
  EXPECT_EQ(drain().poses, 1U);  // and the end is seen
  {
    const auto too_early = connect();
    EXPECT_FALSE(admitted_) << "the slot is free only once housekeeping has closed it";
  }
  door_.close_ended();
  const auto next = connect({30, 40});
  EXPECT_TRUE(admitted_);
  const auto connection = door_.connections()[2];
  EXPECT_TRUE(connection.open);
  EXPECT_EQ(connection.peer.pid, 30);
  EXPECT_EQ(connection.peer.uid, 40U);
  EXPECT_EQ(connection.messages, 0U);
}

TEST_F(CameraDoorTest, ClosesTheConnectionsThatHaveEnded) {
  std::array<int, 2> ends{};
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()), 0);
  ASSERT_TRUE(door_.admit(FileDescriptor(ends[1]), {}));
  ::close(ends[0]);
  drain();
  EXPECT_NE(::fcntl(ends[1], F_GETFD), -1) << "not the beat's to close";
  door_.close_ended();
  EXPECT_EQ(::fcntl(ends[1], F_GETFD), -1);
}

}  // namespace
}  // namespace odomd::daemon::camera_door_test
