#include "daemon/sockets/camera_wire.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

namespace odomd::daemon::camera_wire_test {
namespace {

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
}  // namespace odomd::daemon::camera_wire_test
