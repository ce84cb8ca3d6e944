// The beat: its grid of ticks, its measurements of the machine, and the waking of clients.
#include <atomic>

#include "daemon/realtime/relay.hpp"
#include "daemon/realtime/surroundings.hpp"
#include "daemon/realtime/tick_grid.hpp"
#include "tests/gtest.hpp"

namespace odomd::daemon::beat_test {
namespace {

constexpr std::int64_t second = 1'000'000'000;

TEST(Relay, WakesAllClientsAfterEachRing) {
  std::atomic<int> woken{0};
  Relay relay(2, -1, [&] {
    woken.fetch_add(1);
    woken.notify_all();
  });
  for (int ring = 1; ring <= 100; ++ring) {
    const int before = woken.load();
    relay.ring();
    woken.wait(before);
  }
  EXPECT_EQ(woken.load(), 100);
}

TEST(Relay, EndsWithoutARingAndReportsRefusals) {
  std::atomic<int> woken{0};
  {
    const Relay relay(2, 1023, [&] { woken.fetch_add(1); });
    EXPECT_EQ(relay.grant().cpu, -1);
    EXPECT_THAT(relay.grant().refusals, Contains(HasSubstr("is not pinned to CPU 1023")));
  }
  EXPECT_LE(woken.load(), 1);
}

TEST(Surroundings, ReportStatesNowAndIncidentsForAWhile) {
  const std::int64_t refused_until = 8 * second + Surroundings::refusal_ns;
  const std::pair<Sighting, std::uint32_t> steps[]{
      {{.now_ns = second / 2}, 0},
      {{.now_ns = second / 2, .link_down = true}, ODOM_COND_BUS_DOWN},
      {{.now_ns = second / 2, .input_ended = true}, ODOM_COND_INPUT_ENDED},
      {{.now_ns = second / 2, .carried_over = true}, ODOM_COND_CARRIED_OVER},
      {{.now_ns = second / 2}, 0},
      {{.now_ns = second, .frames_lost = 3}, ODOM_COND_FRAMES_LOST},
      {{.now_ns = 2 * second - 1, .frames_lost = 3}, ODOM_COND_FRAMES_LOST},
      {{.now_ns = 2 * second, .frames_lost = 3}, 0},
      {{.now_ns = 3 * second, .clock_stepped = true, .frames_lost = 3}, ODOM_COND_CLOCK_STEPPED},
      {{.now_ns = 4 * second - 1, .suspended = true, .frames_lost = 3},
       ODOM_COND_CLOCK_STEPPED | ODOM_COND_SUSPENDED},
      {{.now_ns = 6 * second, .frames_lost = 3}, 0},
      {{.now_ns = 8 * second, .frames_lost = 3, .cameras_refused = 2}, ODOM_COND_CAMERA_REFUSED},
      {{.now_ns = refused_until - 1, .frames_lost = 3, .cameras_refused = 2},
       ODOM_COND_CAMERA_REFUSED},
      {{.now_ns = refused_until, .frames_lost = 3, .cameras_refused = 2}, 0}};
  Surroundings quiet(0), refused(ODOM_COND_NOT_REALTIME);
  for (const auto& [now, conditions] : steps) {
    EXPECT_EQ(quiet.conditions(now), conditions) << now.now_ns;
    EXPECT_EQ(refused.conditions(now), conditions | ODOM_COND_NOT_REALTIME) << now.now_ns;
  }
}

TEST(Surroundings, ReportARestartForAWhile) {
  Surroundings surroundings(0);
  surroundings.restarted(second);
  EXPECT_EQ(surroundings.conditions({.now_ns = second}), ODOM_COND_RESTARTED);
  EXPECT_EQ(surroundings.conditions({.now_ns = second + Surroundings::restart_ns - 1}),
            ODOM_COND_RESTARTED);
  EXPECT_EQ(surroundings.conditions({.now_ns = second + Surroundings::restart_ns}), 0U);
}

constexpr std::int64_t period = 5'000'000;
constexpr TickGrid grid{1'000'000'000, period};
constexpr std::int64_t microsecond = 1'000;

TEST(TickGrid, StartsAtTheLastMultipleOfThePeriod) {
  const auto begun = grid_from(12'345'678, period);
  EXPECT_EQ(begun.first_ns, 10'000'000);
  EXPECT_EQ(begun.time_of(1), 15'000'000);
  EXPECT_EQ(grid_from(10'000'000, period).first_ns, 10'000'000);
}

TEST(TickGrid, WakeUpRunsTheNewestDueTick) {
  const auto due = [](std::uint64_t planned, std::int64_t now_ns) {
    const auto [tick, missed] = due_tick(grid, planned, now_ns);
    return std::pair{tick, missed};
  };
  EXPECT_THAT(due(7, grid.time_of(7) + 50 * microsecond), Pair(7, 0));
  EXPECT_THAT(due(7, grid.time_of(8) - 1), Pair(7, 0));
  EXPECT_THAT(due(7, grid.time_of(8)), Pair(8, 1)) << "a period late";
  EXPECT_THAT(due(7, grid.time_of(10) + 3 * microsecond), Pair(10, 3));
  EXPECT_THAT(due(7, grid.time_of(7) - 1), Pair(7, 0)) << "early";
  EXPECT_THAT(due(1, 0), Pair(1, 0)) << "before all";
}

TEST(TickGrid, OverrunSkipsWholePeriodsAndKeepsThePhase) {
  const auto next = [](std::int64_t now_ns) {
    const auto [tick, missed] = next_tick(grid, 7, now_ns);
    return std::pair{tick, missed};
  };
  EXPECT_THAT(next(grid.time_of(7) + 100 * microsecond), Pair(8, 0));
  EXPECT_THAT(next(grid.time_of(8)), Pair(9, 1)) << "done exactly when the next is due";
  EXPECT_THAT(next(grid.time_of(8) + 1), Pair(9, 1));
  EXPECT_THAT(next(grid.time_of(17) + period / 2), Pair(18, 10));
}

TEST(TickGrid, TicksAndMissedCyclesAddUp) {
  // A beat with simulated latencies and execution times, some of them far too long.
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
}  // namespace odomd::daemon::beat_test
