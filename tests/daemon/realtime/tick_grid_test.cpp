#include "daemon/realtime/tick_grid.hpp"

#include <gtest/gtest.h>

namespace odomd::daemon::tick_grid_test {
namespace {

constexpr std::int64_t period = 5'000'000;
constexpr TickGrid grid{1'000'000'000, period};
constexpr std::int64_t microsecond = 1'000;

TEST(TickGrid, BeginsAtAMultipleOfThePeriodBeforeNow) {
  const auto begun = grid_from(12'345'678, period);
  EXPECT_EQ(begun.first_ns, 10'000'000);
  EXPECT_EQ(begun.time_of(1), 15'000'000);
  EXPECT_EQ(grid_from(10'000'000, period).first_ns, 10'000'000);
}

TEST(TickGrid, OnTimeDoesThePlannedTick) {
  const auto due = due_tick(grid, 7, grid.time_of(7) + 50 * microsecond);
  EXPECT_EQ(due.tick, 7U);
  EXPECT_EQ(due.missed, 0U);
}

TEST(TickGrid, ASlightlyLateWakeUpStillDoesThePlannedTick) {
  const auto due = due_tick(grid, 7, grid.time_of(8) - 1);
  EXPECT_EQ(due.tick, 7U);
  EXPECT_EQ(due.missed, 0U);
}

TEST(TickGrid, AWakeUpAPeriodLateDoesTheNewestTickThatIsDue) {
  EXPECT_EQ(due_tick(grid, 7, grid.time_of(8)).tick, 8U);
  const auto due = due_tick(grid, 7, grid.time_of(10) + 3 * microsecond);
  EXPECT_EQ(due.tick, 10U);
  EXPECT_EQ(due.missed, 3U);
}

TEST(TickGrid, AWakeUpBeforeItsTimeDoesThePlannedTick) {
  EXPECT_EQ(due_tick(grid, 7, grid.time_of(7) - 1).tick, 7U);
  EXPECT_EQ(due_tick(grid, 1, 0).tick, 1U);
}

TEST(TickGrid, AfterAQuickTickComesTheNext) {
  const auto next = next_tick(grid, 7, grid.time_of(7) + 100 * microsecond);
  EXPECT_EQ(next.tick, 8U);
  EXPECT_EQ(next.missed, 0U);
}

TEST(TickGrid, AnOverrunSkipsWholePeriodsAndKeepsThePhase) {
  const auto one = next_tick(grid, 7, grid.time_of(8) + 1);
  EXPECT_EQ(one.tick, 9U);
  EXPECT_EQ(one.missed, 1U);
  const auto many = next_tick(grid, 7, grid.time_of(17) + period / 2);
  EXPECT_EQ(many.tick, 18U);
  EXPECT_EQ(many.missed, 10U);
}

TEST(TickGrid, DoneExactlyWhenTheNextIsDueIsAnOverrun) {
  const auto next = next_tick(grid, 7, grid.time_of(8));
  EXPECT_EQ(next.tick, 9U);
  EXPECT_EQ(next.missed, 1U);
}

TEST(TickGrid, TicksAndMissedCyclesAccountForAll) {
  // A beat with made-up latencies and execution times, some of them far too long.
  std::uint64_t planned = 1;
  std::uint64_t ticks = 0;
  std::uint64_t missed = 0;
  std::uint64_t last = 0;
  std::int64_t now = grid.first_ns;
  for (std::int64_t i = 0; i < 1000; ++i) {
    now = std::max(now, grid.time_of(planned)) + (i % 13) * 700 * microsecond;  // wake
    const auto due = due_tick(grid, planned, now);
    EXPECT_GT(due.tick, last);
    last = due.tick;
    ++ticks;
    now += (i % 7) * 1'900 * microsecond;  // work
    const auto next = next_tick(grid, due.tick, now);
    EXPECT_GT(grid.time_of(next.tick), now) << "a beat that cannot keep up still sleeps";
    missed += due.missed + next.missed;
    planned = next.tick;
  }
  EXPECT_EQ(ticks + missed, planned - 1);
  EXPECT_GT(missed, 0U);
}

}  // namespace
}  // namespace odomd::daemon::tick_grid_test
