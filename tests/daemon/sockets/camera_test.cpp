// Camera messages over real socket pairs: which are accepted, how they are interpreted, and when a
// connection ends.
#include <fcntl.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>

#include "daemon/sockets/camera_door.hpp"
#include "daemon/sockets/camera_wire.hpp"
#include "tests/gtest.hpp"

namespace odomd::daemon::camera_test {
namespace {

using Admission = CameraDoor::Admission;

class CameraDoorTest : public testing::Test {
 protected:
  /// Connects a camera; returns the camera's end.
  FileDescriptor connect(Peer peer = {1, 2}) {
    std::array<int, 2> ends{};
    EXPECT_EQ(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()), 0);
    FileDescriptor mine(ends[0]);
    admission_ = door_.admit(FileDescriptor(ends[1]), peer, now_ns_);
    admitted_ = admission_ == Admission::free_slot;
    return mine;
  }
  /// The error sent before the connection was closed; 0: none sent; empty: it is still open.
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
  EXPECT_EQ(drain().poses, 1U);  // and notices the end
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

  // The first sends a pose, the second an invalid message, which counts as idle.
  send(cameras[0], 1);
  EXPECT_EQ(::send(cameras[1].get(), "x", 1, MSG_NOSIGNAL), 1);
  drain();
  now_ns_ += 1001;
  const auto next = connect({30, 40});
  EXPECT_EQ(admission_, Admission::in_place_of_idle);
  EXPECT_EQ(refusal(connect()), -EBUSY) << "no other has been idle for so long";
  send(next, 2);
  drain();  // notices the end
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

constexpr std::int64_t arrival = 9'000'000;
constexpr std::int64_t offset = 1'000'000;  // CLOCK_REALTIME - CLOCK_MONOTONIC

void read_at(WallClock& wall, std::int64_t monotonic_ns, std::int64_t offset_ns) {
  wall.update({monotonic_ns, monotonic_ns + offset_ns, monotonic_ns, monotonic_ns});
}

const WallClock steady = [] {
  WallClock wall;
  read_at(wall, 1'000'000, offset);
  return wall;
}();
const MessageClocks clocks{.wall = steady, .log_ns = -500};

odom_camera_message message() {
  odom_camera_message message{};
  message.magic = ODOM_CAMERA_MAGIC;
  message.version = ODOM_CAMERA_VERSION;
  message.clock = ODOM_CLOCK_MONOTONIC;
  message.capture_ns = 8'000'000;
  message.x = 1.0;
  message.y = 2.0;
  message.yaw = 3.0;
  message.sigma_x = 0.1;
  message.sigma_y = 0.2;
  message.sigma_yaw = 0.3;
  return message;
}

CameraMessage read(const odom_camera_message& message, const MessageClocks& by = clocks) {
  return read_camera_message(std::as_bytes(std::span(&message, 1)), sizeof message, by, arrival);
}

TEST(CameraWire, ReadsAPoseOnTheMonotonicClock) {
  const auto result = read(message());
  ASSERT_EQ(result.cause, MalformedCause::none);
  EXPECT_EQ(result.pose.capture_ns, 8'000'000);
  EXPECT_EQ(result.pose.arrival_ns, arrival);
  EXPECT_EQ(result.pose.x, 1.0);
  EXPECT_EQ(result.pose.y, 2.0);
  EXPECT_EQ(result.pose.yaw, 3.0);
  EXPECT_EQ(result.pose.sigma_x, 0.1);
  EXPECT_EQ(result.pose.sigma_y, 0.2);
  EXPECT_EQ(result.pose.sigma_yaw, 0.3);
}

TEST(CameraWire, ConvertsTheOtherClocks) {
  auto given = message();
  given.clock = ODOM_CLOCK_REALTIME;
  EXPECT_EQ(read(given).pose.capture_ns, 7'000'000);
  given.clock = ODOM_CLOCK_LOG;
  EXPECT_EQ(read(given).pose.capture_ns, 8'000'500);
}

TEST(CameraWire, APictureFromBeforeTheWallClockWasSetKeepsItsTime) {
  constexpr std::int64_t hour = 3'600'000'000'000;
  for (const std::int64_t step : {-hour, hour}) {
    WallClock wall;
    read_at(wall, 7'000'000, offset);
    read_at(wall, 8'500'000, offset + step);
    auto given = message();
    given.clock = ODOM_CLOCK_REALTIME;
    given.capture_ns = 8'000'000 + offset;  // half a millisecond before the step
    EXPECT_EQ(read(given, {wall, {}}).pose.capture_ns, 8'000'000);
    given.capture_ns = 8'800'000 + offset + step;  // after it
    EXPECT_EQ(read(given, {wall, {}}).pose.capture_ns, 8'800'000);
  }
}

TEST(CameraWire, AWallTimeThatNoOffsetExplainsIsLeftToTheFilter) {
  auto given = message();
  given.clock = ODOM_CLOCK_REALTIME;
  given.capture_ns = arrival + offset + 60'000'000'000;
  EXPECT_EQ(read(given).pose.capture_ns, arrival + 60'000'000'000);
  given.capture_ns = arrival + offset - 60'000'000'000;
  EXPECT_EQ(read(given).pose.capture_ns, arrival - 60'000'000'000);
}

TEST(CameraWire, NamesWhatIsMalformed) {
  const auto cause_of = [](auto change) {
    auto given = message();
    change(given);
    return read(given).cause;
  };
  EXPECT_EQ(cause_of([](auto& m) { m.magic = 1; }), MalformedCause::magic);
  EXPECT_EQ(cause_of([](auto& m) { m.version = 2; }), MalformedCause::version);
  EXPECT_EQ(cause_of([](auto& m) { m.clock = 3; }), MalformedCause::clock);
  EXPECT_EQ(cause_of([](auto& m) { m.reserved = 1; }), MalformedCause::reserved);

  auto log = message();
  log.clock = ODOM_CLOCK_LOG;
  EXPECT_EQ(read(log, {.wall = steady, .log_ns = std::nullopt}).cause, MalformedCause::no_log);
}

TEST(CameraWire, RefusesAnyOtherSize) {
  const auto given = message();
  const auto bytes = std::as_bytes(std::span(&given, 1));
  for (const std::size_t size : {0U, 1U, 79U, 81U, 65536U})
    EXPECT_EQ(read_camera_message(bytes, size, clocks, arrival).cause, MalformedCause::size);
  EXPECT_EQ(read_camera_message(bytes.first(10), sizeof given, clocks, arrival).cause,
            MalformedCause::size);
}

TEST(CameraWire, RefusesTimesThatCannotBeConverted) {
  constexpr auto smallest = std::numeric_limits<std::int64_t>::min();
  constexpr auto largest = std::numeric_limits<std::int64_t>::max();
  for (const std::uint16_t clock : {ODOM_CLOCK_MONOTONIC, ODOM_CLOCK_REALTIME, ODOM_CLOCK_LOG})
    for (const std::int64_t capture : {smallest, smallest + 1, largest - 1, largest}) {
      auto given = message();
      given.clock = clock;
      given.capture_ns = capture;
      EXPECT_EQ(read(given).cause, MalformedCause::time) << clock << " " << capture;
    }
}

TEST(CameraWire, LeavesValuesThatAreNotFiniteToTheFilter) {
  auto given = message();
  given.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(read(given).cause, MalformedCause::none);
}

}  // namespace
}  // namespace odomd::daemon::camera_test
