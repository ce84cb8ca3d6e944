// Hardware stamps from a device clock with drift, aligned with software stamps with jitter.
#include "can_protocol/sources/device_clock.hpp"

#include <cstdlib>
#include <random>
#include <tuple>

#include "tests/gtest.hpp"

namespace odomd::can::device_clock_test {
namespace {

constexpr std::int64_t us = 1'000;
constexpr std::int64_t ms = 1'000 * us;
constexpr std::int64_t s = 1'000 * ms;

/// A controller whose clock reads at(t) at instant t.
struct Device {
  std::int64_t origin = 0;
  std::int64_t drift_per_million = 0;
  [[nodiscard]] std::int64_t at(std::int64_t time) const {
    return origin + time + time / 1'000'000 * drift_per_million;
  }
};

/// Latency of software stamps: never negative, mostly 10-60 us, sometimes a millisecond.
class Latency {
 public:
  std::int64_t next() {
    const auto draw = static_cast<std::int64_t>(random_() % 1000);
    return draw < 50 ? 10 * us + draw * 20 * us : 10 * us + draw * 50;
  }

 private:
  std::minstd_rand random_{42};
};

/// Maps a stamp every millisecond, each 10 us late, in [from, to).
void feed(DeviceClock& clock, const Device& device, std::int64_t from, std::int64_t to) {
  for (std::int64_t time = from; time < to; time += ms)
    ASSERT_LE(clock.to_monotonic(device.at(time), time + 10 * us), time + 10 * us);
}

TEST(DeviceClock, IsFollowedToTheSmallestLatency) {
  for (const std::int64_t drift_per_million : {-100, -50, 0, 50, 100}) {
    const Device device{-123'456'789'012, drift_per_million};
    DeviceClock clock;
    Latency latency;
    std::int64_t worst = 0;
    for (std::int64_t i = 0; i < 60'000; ++i) {  // one minute with a frame per millisecond
      const std::int64_t time = 1000 * s + i * ms;
      const std::int64_t software = time + latency.next();
      const std::int64_t mapped = clock.to_monotonic(device.at(time), software);
      ASSERT_LE(mapped, software);
      if (i > 2000) worst = std::max(worst, std::abs(mapped - time));
    }
    EXPECT_LT(worst, 30 * us) << drift_per_million;
  }
}

TEST(DeviceClock, FollowsAClockThatJumpsAheadOrStartsOverAtOnce) {
  for (const auto& [origin, later] : {std::pair{0 * s, 7 * s}, {500 * s, 0 * s}}) {
    Device device{origin, 0};
    DeviceClock clock;
    feed(clock, device, 0, 100 * ms);
    device.origin = later;
    const std::int64_t time = 101 * ms;
    EXPECT_EQ(clock.to_monotonic(device.at(time), time + 10 * us), time + 10 * us) << later;
  }
}

TEST(DeviceClock, FollowsAClockThatFallsBackALittleWithinTwoWindows) {
  Device device;
  DeviceClock clock;
  feed(clock, device, 0, 3 * s);
  device.origin -= 20 * ms;
  const std::int64_t time = 3 * s + 2 * DeviceClock::window_ns + ms;
  feed(clock, device, 3 * s, time);
  EXPECT_LE(std::abs(clock.to_monotonic(device.at(time), time + 10 * us) - time), 20 * us);
}

TEST(DeviceClock, IsRightAfterALongSilenceAndAfterOneLateSoftwareStamp) {
  // 80 ppm of a minute: 4.8 ms.
  for (const auto& [time, late, drift] : {std::tuple{63 * s, 10 * us, -80}, {3 * s, 30 * ms, 0}}) {
    const Device device{5 * s, drift};
    DeviceClock clock;
    feed(clock, device, 0, 3 * s);
    EXPECT_LE(std::abs(clock.to_monotonic(device.at(time), time + late) - time), 20 * us);
  }
}

}  // namespace
}  // namespace odomd::can::device_clock_test
