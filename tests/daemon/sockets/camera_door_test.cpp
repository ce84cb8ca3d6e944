// The camera connections over real socket pairs: what the beat reads from them, and when they end.
#include "daemon/sockets/camera_door.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <memory>
#include <optional>
#include <vector>

namespace odomd::daemon::camera_door_test {
namespace {

using Admission = CameraDoor::Admission;

class CameraDoorTest : public testing::Test {
 protected:
  /// Connects a camera; its end.
  FileDescriptor connect(Peer peer = {1, 2}) {
    std::array<int, 2> ends{};
    EXPECT_EQ(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()), 0);
    FileDescriptor mine(ends[0]);
    admission_ = door_.admit(FileDescriptor(ends[1]), peer, now_ns_);
    admitted_ = admission_ == Admission::free_slot;
    return mine;
  }
  /// What the daemon sent before it closed the connection; empty if it is open, 0 if nothing.
  static std::optional<std::int32_t> refusal(const FileDescriptor& camera) {
    std::int32_t reason = 0;
    const ssize_t size = ::recv(camera.get(), &reason, sizeof reason, MSG_DONTWAIT);
    return size < 0 ? std::nullopt : std::optional(reason);
  }

  static void send(const FileDescriptor& camera, std::int64_t capture_ns) {
    odom_camera_message message{};
    message.magic = ODOM_CAMERA_MAGIC;
    message.version = ODOM_CAMERA_VERSION;
    message.capture_ns = capture_ns;
    EXPECT_EQ(::send(camera.get(), &message, sizeof message, MSG_NOSIGNAL),
              static_cast<ssize_t>(sizeof message));
  }

  CameraDoor::Drained drain() { return door_.drain(poses_, {wall_, {}}, now_ns_, *events_); }

  CameraDoor door_;
  std::unique_ptr<EventRing> events_ = std::make_unique<EventRing>();
  WallClock wall_;
  std::array<estimator::CameraPose, CameraDoor::max_poses> poses_{};
  std::int64_t now_ns_ = 77;
  Admission admission_ = Admission::refused;
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
  door_.close_ended(now_ns_);
  const auto next = connect({30, 40});
  EXPECT_TRUE(admitted_);
  const auto connection = door_.connections()[2];
  EXPECT_TRUE(connection.open);
  EXPECT_EQ(connection.peer.pid, 30);
  EXPECT_EQ(connection.peer.uid, 40U);
  EXPECT_EQ(connection.messages, 0U);
}

TEST_F(CameraDoorTest, TheConnectionThatWasIdleLongestMakesRoomAfterTwoSeconds) {
  std::vector<FileDescriptor> cameras;
  for (std::size_t i = 0; i < CameraDoor::max_connections; ++i) {
    cameras.push_back(connect({static_cast<pid_t>(i), 2}));
    now_ns_ += 1000;
  }
  now_ns_ = 77 + CameraDoor::idle_ns - 1;
  EXPECT_EQ(refusal(connect()), -EBUSY);
  EXPECT_EQ(admission_, Admission::refused);
  EXPECT_EQ(door_.refused(), 1U);

  // The first sends a pose, the second rubbish, which does not count.
  send(cameras[0], 1);
  EXPECT_EQ(::send(cameras[1].get(), "x", 1, MSG_NOSIGNAL), 1);
  drain();
  now_ns_ += 1001;
  const auto next = connect({30, 40});
  EXPECT_EQ(admission_, Admission::in_place_of_idle);
  EXPECT_EQ(refusal(connect()), -EBUSY) << "no other has been idle for so long";
  send(next, 2);
  drain();  // sees the end
  door_.close_ended(now_ns_);
  EXPECT_EQ(refusal(cameras[1]), 0) << "closed, without a word: it may connect again";
  for (const std::size_t kept : {0U, 2U, 3U}) EXPECT_EQ(refusal(cameras[kept]), std::nullopt);
  EXPECT_EQ(door_.connections()[1].peer.pid, 30);
  EXPECT_EQ(door_.connections()[1].messages, 0U);
  EXPECT_EQ(drain().poses, 1U) << "what it sent while it waited";
}

TEST_F(CameraDoorTest, ClosesTheConnectionsThatHaveEnded) {
  std::array<int, 2> ends{};
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()), 0);
  ASSERT_EQ(door_.admit(FileDescriptor(ends[1]), {}, now_ns_), Admission::free_slot);
  ::close(ends[0]);
  drain();
  EXPECT_NE(::fcntl(ends[1], F_GETFD), -1) << "not the beat's to close";
  door_.close_ended(now_ns_);
  EXPECT_EQ(::fcntl(ends[1], F_GETFD), -1);
}

}  // namespace
}  // namespace odomd::daemon::camera_door_test
