// Camera messages over real socket pairs: which are accepted, how they are interpreted, and when a
// connection ends.
#include <fcntl.h>
#include <sys/socket.h>

#include <cerrno>
#include <memory>
#include <optional>

#include "daemon/sockets/camera_server.hpp"
#include "tests/gtest.hpp"

namespace odomd::daemon::camera_test {
namespace {

using testing::FieldsAre;
using Admission = CameraServer::Admission;

class CameraServerTest : public testing::Test {
 protected:
  /// Connects a camera; returns the camera's end.
  FileDescriptor connect(Peer peer = {1, 2}) {
    std::array<int, 2> ends{};
    EXPECT_EQ(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()), 0);
    FileDescriptor mine(ends[0]);
    theirs_ = ends[1];
    admission_ = server_.admit(FileDescriptor(ends[1]), peer, now_ns_);
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

  CameraServer::Drained drain() { return server_.drain(poses_, {wall_, {}}, now_ns_, *events_); }
  /// The capture times of the poses that are drained.
  std::vector<std::int64_t> captures() {
    std::vector<std::int64_t> times;
    const std::size_t poses = drain().poses;
    for (std::size_t i = 0; i < poses; ++i) times.push_back(poses_.at(i).capture_ns);
    return times;
  }

  CameraServer server_;
  std::unique_ptr<EventRing> events_ = std::make_unique<EventRing>();
  WallClock wall_;
  std::array<estimator::CameraPose, CameraServer::max_poses> poses_{};
  std::int64_t now_ns_ = 77;
  Admission admission_ = Admission::refused;
  int theirs_ = -1;
};

TEST_F(CameraServerTest, ReadsWhatEachConnectionSent) {
  EXPECT_THAT(captures(), IsEmpty());
  const auto one = connect();
  const auto two = connect();
  send(one, 10);
  send(one, 11);
  send(two, 20);
  EXPECT_THAT(captures(), ElementsAre(10, 11, 20));
  EXPECT_EQ(poses_[0].arrival_ns, 77);
  EXPECT_THAT(captures(), IsEmpty());
}

TEST_F(CameraServerTest, LimitsTheMessagesPerTick) {
  const auto camera = connect();
  constexpr std::size_t sent = CameraServer::max_messages_per_drain + 3;
  for (std::size_t i = 0; i < sent; ++i) send(camera, static_cast<std::int64_t>(i));
  EXPECT_EQ(captures().size(), CameraServer::max_messages_per_drain);
  EXPECT_THAT(captures(), ElementsAre(sent - 3, sent - 2, sent - 1));
}

TEST_F(CameraServerTest, CountsMalformedMessagesWithTheirCause) {
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
  EXPECT_EQ(server_.connections()[0].messages, 4U);
  EXPECT_EQ(server_.connections()[0].malformed, 3U);
}

TEST_F(CameraServerTest, ReadsTheLastMessagesAndLeavesClosingToHousekeeping) {
  auto camera = connect();
  send(camera, 1);
  camera = {};
  EXPECT_THAT(captures(), ElementsAre(1));
  EXPECT_EQ(events_->next()->kind, EventKind::camera_gone);
  EXPECT_FALSE(server_.connections()[0].open);
  EXPECT_NE(::fcntl(theirs_, F_GETFD), -1) << "not the beat's to close";
  server_.close_ended(now_ns_);
  EXPECT_EQ(::fcntl(theirs_, F_GETFD), -1);
}

TEST_F(CameraServerTest, AdmitsFourConnectionsAndAnotherAfterOneCloses) {
  std::vector<FileDescriptor> cameras;
  for (std::size_t i = 0; i < CameraServer::max_connections; ++i) {
    cameras.push_back(connect());
    EXPECT_EQ(admission_, Admission::free_slot);
  }
  EXPECT_EQ(refusal(connect()), -EBUSY);
  send(cameras[2], 3);
  cameras[2] = {};
  drain();  // notices the end
  EXPECT_EQ(refusal(connect()), -EBUSY) << "the slot is free only once housekeeping has closed it";
  server_.close_ended(now_ns_);
  const auto next = connect({30, 40});
  EXPECT_EQ(admission_, Admission::free_slot);
  EXPECT_THAT(server_.connections()[2], FieldsAre(true, FieldsAre(30, 40U, testing::_), 0U, 0U));
}

TEST_F(CameraServerTest, ReplacesTheLongestIdleConnectionAfterTwoSeconds) {
  std::vector<FileDescriptor> cameras;
  for (std::size_t i = 0; i < CameraServer::max_connections; ++i) {
    cameras.push_back(connect({static_cast<pid_t>(i), 2}));
    now_ns_ += 1000;
  }
  now_ns_ = 77 + CameraServer::idle_ns - 1;
  EXPECT_EQ(refusal(connect()), -EBUSY);
  EXPECT_EQ(admission_, Admission::refused);
  EXPECT_EQ(server_.refused(), 1U);

  // The first camera sends a pose; the second sends an invalid message, which counts as idle.
  send(cameras[0], 1);
  EXPECT_EQ(::send(cameras[1].get(), "x", 1, MSG_NOSIGNAL), 1);
  drain();
  now_ns_ += 1001;
  const auto next = connect({30, 40});
  EXPECT_EQ(admission_, Admission::in_place_of_idle);
  EXPECT_EQ(refusal(connect()), -EBUSY) << "no other has been idle for so long";
  send(next, 2);
  drain();  // notices the end
  server_.close_ended(now_ns_);
  EXPECT_EQ(refusal(cameras[1]), 0) << "closed, without a word: it may connect again";
  for (const std::size_t kept : {0U, 2U, 3U}) EXPECT_EQ(refusal(cameras[kept]), std::nullopt);
  EXPECT_EQ(server_.connections()[1].peer.pid, 30);
  EXPECT_EQ(server_.connections()[1].messages, 0U);
  EXPECT_EQ(drain().poses, 1U) << "what it sent while it waited";
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

/// The capture time of a message whose stamp on `clock` is `time_ns`.
std::int64_t capture_of(odom_clock clock, std::int64_t time_ns, const MessageClocks& by = clocks) {
  auto given = message();
  given.clock = clock;
  given.capture_ns = time_ns;
  return read(given, by).pose.capture_ns;
}

TEST(CameraMessage, ReadsAPoseOnAnyClock) {
  EXPECT_THAT(read(message()), FieldsAre(MalformedCause::none, FieldsAre(8'000'000, arrival, 1.0,
                                                                         2.0, 3.0, 0.1, 0.2, 0.3)));
  EXPECT_EQ(capture_of(ODOM_CLOCK_REALTIME, 8'000'000), 7'000'000);
  EXPECT_EQ(capture_of(ODOM_CLOCK_LOG, 8'000'000), 8'000'500);
  // A wall time that no offset explains is left to the filter.
  for (const std::int64_t far : {60'000'000'000, -60'000'000'000})
    EXPECT_EQ(capture_of(ODOM_CLOCK_REALTIME, arrival + offset + far), arrival + far);
}

TEST(CameraMessage, ConvertsAStampFromBeforeAStepOfTheWallClock) {
  constexpr std::int64_t hour = 3'600'000'000'000;
  for (const std::int64_t step : {-hour, hour}) {
    WallClock wall;
    read_at(wall, 7'000'000, offset);
    read_at(wall, 8'500'000, offset + step);
    // Half a millisecond before the step, and after it.
    EXPECT_EQ(capture_of(ODOM_CLOCK_REALTIME, 8'000'000 + offset, {wall, {}}), 8'000'000);
    EXPECT_EQ(capture_of(ODOM_CLOCK_REALTIME, 8'800'000 + offset + step, {wall, {}}), 8'800'000);
  }
}

TEST(CameraMessage, NamesTheCauseOfAMalformedMessage) {
  const auto cause_of = [](auto change, const MessageClocks& by = clocks) {
    auto given = message();
    change(given);
    return read(given, by).cause;
  };
  EXPECT_EQ(cause_of([](auto& m) { m.magic = 1; }), MalformedCause::magic);
  EXPECT_EQ(cause_of([](auto& m) { m.version = 2; }), MalformedCause::version);
  EXPECT_EQ(cause_of([](auto& m) { m.clock = 3; }), MalformedCause::clock);
  EXPECT_EQ(cause_of([](auto& m) { m.reserved = 1; }), MalformedCause::reserved);
  EXPECT_EQ(cause_of([](auto& m) { m.clock = ODOM_CLOCK_LOG; }, {steady, std::nullopt}),
            MalformedCause::no_log);
  // The filter has a verdict for values that are not finite.
  EXPECT_EQ(cause_of([](auto& m) { m.x = std::nan(""); }), MalformedCause::none);
}

TEST(CameraMessage, RefusesAnyOtherSize) {
  const auto given = message();
  const auto bytes = std::as_bytes(std::span(&given, 1));
  for (const std::size_t size : {0U, 1U, 79U, 81U, 65536U})
    EXPECT_EQ(read_camera_message(bytes, size, clocks, arrival).cause, MalformedCause::size);
  EXPECT_EQ(read_camera_message(bytes.first(10), sizeof given, clocks, arrival).cause,
            MalformedCause::size);
}

TEST(CameraMessage, RefusesTimesThatCannotBeConverted) {
  auto given = message();
  for (const std::uint16_t clock : {ODOM_CLOCK_MONOTONIC, ODOM_CLOCK_REALTIME, ODOM_CLOCK_LOG})
    for (const std::int64_t capture : {INT64_MIN, INT64_MIN + 1, INT64_MAX - 1, INT64_MAX}) {
      given.clock = clock;
      given.capture_ns = capture;
      EXPECT_EQ(read(given).cause, MalformedCause::time) << clock << " " << capture;
    }
}

}  // namespace
}  // namespace odomd::daemon::camera_test
