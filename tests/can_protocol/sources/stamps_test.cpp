// Hardware stamps from a device clock with drift, aligned with software stamps with jitter. Each
// verdict on a time stamp, and which identifiers the guard distinguishes.
#include "can_protocol/sources/device_clock.hpp"

#include <cstdlib>
#include <memory>
#include <random>
#include <tuple>

#include "can_protocol/sources/stamp_guard.hpp"
#include "tests/gtest.hpp"

namespace odomd::can::stamps_test {
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

TEST(DeviceClock, ConvertsUpToTheSmallestLatency) {
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

TEST(DeviceClock, FollowsAJumpAheadOrARestartAtOnce) {
  for (const auto& [origin, later] : {std::pair{0 * s, 7 * s}, {500 * s, 0 * s}}) {
    Device device{origin, 0};
    DeviceClock clock;
    feed(clock, device, 0, 100 * ms);
    device.origin = later;
    const std::int64_t time = 101 * ms;
    EXPECT_EQ(clock.to_monotonic(device.at(time), time + 10 * us), time + 10 * us) << later;
  }
}

TEST(DeviceClock, FollowsASmallBackwardStepWithinTwoWindows) {
  Device device;
  DeviceClock clock;
  feed(clock, device, 0, 3 * s);
  device.origin -= 20 * ms;
  const std::int64_t time = 3 * s + 2 * DeviceClock::window_ns + ms;
  feed(clock, device, 3 * s, time);
  EXPECT_LE(std::abs(clock.to_monotonic(device.at(time), time + 10 * us) - time), 20 * us);
}

TEST(DeviceClock, SurvivesALongSilenceAndALateSoftwareStamp) {
  // 80 ppm of a minute: 4.8 ms.
  for (const auto& [time, late, drift] : {std::tuple{63 * s, 10 * us, -80}, {3 * s, 30 * ms, 0}}) {
    const Device device{5 * s, drift};
    DeviceClock clock;
    feed(clock, device, 0, 3 * s);
    EXPECT_LE(std::abs(clock.to_monotonic(device.at(time), time + late) - time), 20 * us);
  }
}

// The guard of the stamps -------------------------------------------------------------------------

constexpr std::int64_t now = 1'000'000 * ms;

class StampGuardTest : public testing::Test {
 protected:
  StampVerdict check(std::int64_t time_ns, std::uint32_t id = 0x120, std::uint8_t bus = 0,
                     IdFormat format = IdFormat::standard) {
    return guard_->check({.time_ns = time_ns, .id = id, .format = format, .bus = bus}, now);
  }
  std::unique_ptr<StampGuard> guard_ = std::make_unique<StampGuard>();
};

TEST_F(StampGuardTest, TrustsStampsThatRise) {
  for (std::int64_t time = 1; time < 100; ++time)
    EXPECT_EQ(check(now - 100 * ms + time), StampVerdict::trusted);
}

TEST_F(StampGuardTest, GivesEveryStampItsVerdict) {
  using enum StampVerdict;
  for (const auto& [time_ns, verdict] :
       {std::pair{std::int64_t{0}, zero},
        {-5 * ms, zero},
        {now - 5 * ms, trusted},
        {now - 5 * ms, repeated},
        {now - 6 * ms, backwards},
        {now - 4 * ms, trusted},
        {INT64_MAX, future},
        {now - 1 * ms, trusted},  // not moved by the future stamp
        {now + StampGuard::tolerance_ns + 1, future},
        {now + StampGuard::tolerance_ns, trusted}})  // within a clock's resolution
    EXPECT_EQ(check(time_ns), verdict) << time_ns;
}

TEST_F(StampGuardTest, DistinguishesBusesIdentifiersAndFormats) {
  EXPECT_EQ(check(now - 5 * ms, 0x120, 0), StampVerdict::trusted);
  EXPECT_EQ(check(now - 5 * ms, 0x121, 0), StampVerdict::trusted);
  EXPECT_EQ(check(now - 6 * ms, 0x120, 1), StampVerdict::trusted);
  EXPECT_EQ(check(now - 6 * ms, 0x120, 0, IdFormat::extended), StampVerdict::trusted);
  EXPECT_EQ(check(now - 6 * ms, 0x120, 0), StampVerdict::backwards);
}

TEST_F(StampGuardTest, RestartsWhenTheClockWasSetBack) {
  EXPECT_EQ(check(now), StampVerdict::trusted);
  EXPECT_EQ(check(now - StampGuard::restart_ns), StampVerdict::trusted);
  EXPECT_EQ(check(now - StampGuard::restart_ns + 1), StampVerdict::trusted);
}

TEST_F(StampGuardTest, ContinuesWhenItsTableIsFull) {
  for (std::uint32_t id = 0; id < 20'000; ++id)
    EXPECT_EQ(check(now - 5 * ms, id, 0, IdFormat::extended), StampVerdict::trusted);
  // Identifiers beyond the capacity are still checked for zero and future.
  EXPECT_EQ(check(0, 19'999, 0, IdFormat::extended), StampVerdict::zero);
  EXPECT_EQ(check(now + 100 * ms, 19'999, 0, IdFormat::extended), StampVerdict::future);
  // The first identifiers are kept.
  EXPECT_EQ(check(now - 6 * ms, 0, 0, IdFormat::extended), StampVerdict::backwards);
}

}  // namespace
}  // namespace odomd::can::stamps_test
