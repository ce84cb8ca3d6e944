// Conversion of stamps while the wall clock is stepped, set back or suspended, in simulated time.
#include "base/wall_clock.hpp"
#include "tests/gtest.hpp"

namespace odomd::wall_clock_test {
namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t s = 1'000 * ms;

/// The machine's clocks: their readings at an instant of MONOTONIC.
struct Machine {
  std::int64_t wall_offset = 1'760'000'000 * s;
  std::int64_t slept = 0;

  [[nodiscard]] ClockReading read(std::int64_t monotonic, std::int64_t width = 100) const {
    return {monotonic - width / 3, monotonic + wall_offset, monotonic + slept,
            monotonic + width - width / 3};
  }
  [[nodiscard]] std::int64_t wall(std::int64_t monotonic) const { return monotonic + wall_offset; }
};

/// The stamp, when converted at `now`, must give `time` on MONOTONIC.
void expect_time(const WallClock& clock, std::int64_t stamp, std::int64_t now, std::int64_t time,
                 double tolerance_ns = 1000.0) {
  const auto converted = clock.to_monotonic(stamp, now);
  ASSERT_TRUE(converted);
  EXPECT_NEAR(static_cast<double>(*converted - time), 0.0, tolerance_ns);
}

TEST(WallClock, ConvertsToTheNanosecondAfterManyReadings) {
  const Machine machine;
  WallClock clock;
  for (std::int64_t tick = 0; tick < 1000; ++tick)
    EXPECT_EQ(clock.update(machine.read(100 * s + tick * 5 * ms, 90 + tick * 7 % 50)),
              ClockEvent::none);
  const std::int64_t now = 105 * s;
  expect_time(clock, machine.wall(now - 3 * ms), now, now - 3 * ms, 50.0);
  EXPECT_NEAR(static_cast<double>(clock.offset_ns() - machine.wall_offset), 0.0, 50.0);
}

TEST(WallClock, IgnoresAnInterruptedReading) {
  const Machine machine;
  WallClock clock;
  clock.update(machine.read(100 * s, 10));
  const std::int64_t before = clock.offset_ns();
  EXPECT_EQ(clock.update({100 * s + 1, machine.wall(101 * s), 101 * s, 104 * s}), ClockEvent::none);
  EXPECT_EQ(clock.offset_ns(), before);
}

TEST(WallClock, ConvertsEachStampWithTheOffsetOfItsTime) {
  for (const std::int64_t step : {-3600 * s, -10 * s, -20 * ms, 20 * ms, 10 * s, 3600 * s,
                                  3650 * 86400 * s, -1'700'000'000 * s}) {
    SCOPED_TRACE(step);
    Machine machine;
    WallClock clock;
    for (std::int64_t tick = 0; tick < 100; ++tick)
      clock.update(machine.read(100 * s + tick * 5 * ms));
    // The clock is set 2 ms after its last reading; one frame came before that step, one after.
    const std::int64_t last = 100 * s + 495 * ms;
    const std::int64_t stamp_before = machine.wall(last + 1 * ms);
    machine.wall_offset += step;
    const std::int64_t stamp_after = machine.wall(last + 3 * ms);
    const std::int64_t now = last + 5 * ms;
    EXPECT_EQ(clock.update(machine.read(now)), ClockEvent::stepped);
    expect_time(clock, stamp_before, now, last + 1 * ms);
    expect_time(clock, stamp_after, now, last + 3 * ms);
    // A frame that waited longer in the socket is still converted, unless the clock was set back by
    // less than this wait: then its stamp has occurred twice.
    const std::int64_t later = now + 50 * ms;
    EXPECT_EQ(clock.update(machine.read(later)), ClockEvent::none);
    if (step > 0 || step <= last - later) expect_time(clock, stamp_before, later, last + 1 * ms);
  }
}

TEST(WallClock, DetectsASmallStep) {
  Machine machine;
  WallClock clock;
  clock.update(machine.read(100 * s));
  machine.wall_offset += 2'000;
  EXPECT_EQ(clock.update(machine.read(100 * s + 5 * ms)), ClockEvent::stepped);
  EXPECT_EQ(clock.update(machine.read(100 * s + 10 * ms)), ClockEvent::none);
}

TEST(WallClock, FollowsRepeatedSteps) {
  Machine machine;
  WallClock clock;
  clock.update(machine.read(100 * s));
  for (std::int64_t tick = 1; tick < 50; ++tick) {
    const std::int64_t now = 100 * s + tick * 5 * ms;
    machine.wall_offset += tick % 2 == 0 ? 7200 * s : -7200 * s;
    const std::int64_t stamp = machine.wall(now - ms);
    EXPECT_EQ(clock.update(machine.read(now)), ClockEvent::stepped);
    expect_time(clock, stamp, now, now - ms);
  }
}

TEST(WallClock, DistinguishesASuspendFromAStep) {
  Machine machine;
  WallClock clock;
  clock.update(machine.read(100 * s));
  const std::int64_t stamp_before = machine.wall(100 * s + ms);
  machine.wall_offset += 600 * s;
  machine.slept += 600 * s;
  const std::int64_t now = 100 * s + 5 * ms;
  EXPECT_EQ(clock.update(machine.read(now)), ClockEvent::suspended);
  expect_time(clock, stamp_before, now, 100 * s + ms);
  EXPECT_EQ(clock.update(machine.read(now + 5 * ms)), ClockEvent::none);
}

TEST(WallClock, RefusesAStampThatNoOffsetMakesPlausible) {
  const Machine machine;
  WallClock clock;
  const std::int64_t now = 100 * s;
  clock.update(machine.read(now));
  EXPECT_FALSE(clock.to_monotonic(machine.wall(now + 2 * ms), now));
  EXPECT_FALSE(clock.to_monotonic(machine.wall(now - 11 * s), now));
  EXPECT_FALSE(clock.to_monotonic(1, now));
  EXPECT_TRUE(clock.to_monotonic(machine.wall(now - 9 * s), now));
}

TEST(WallClock, NeverConvertsToAfterNow) {
  const Machine machine;
  WallClock clock;
  const std::int64_t now = 100 * s;
  clock.update(machine.read(now, 40'000));
  for (std::int64_t lead = 0; lead < 20'000; lead += 1000) {
    const auto time = clock.to_monotonic(machine.wall(now + lead), now);
    ASSERT_TRUE(time);
    EXPECT_LE(*time, now);
  }
}

TEST(WallClock, AgreesWithThisMachine) {
  WallClock clock;
  for (int i = 0; i < 100; ++i) {
    const ClockReading reading = read_clocks();
    EXPECT_LE(reading.before_ns, reading.after_ns);
    clock.update(reading);
  }
  const ClockReading reading = read_clocks();
  const auto time = clock.to_monotonic(reading.realtime_ns, reading.after_ns);
  ASSERT_TRUE(time);
  EXPECT_GE(*time, reading.before_ns - 50'000);
  EXPECT_LE(*time, reading.after_ns);
}

}  // namespace
}  // namespace odomd::wall_clock_test
