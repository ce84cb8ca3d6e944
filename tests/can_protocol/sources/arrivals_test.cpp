// The log clock for live pipes: clocks that are stepped, fast or slow; delayed lines; and steps of
// the clock that stamps the lines.
#include "can_protocol/sources/arrivals.hpp"

#include <functional>
#include <optional>
#include <random>

#include "tests/gtest.hpp"

namespace odomd::can::arrivals_test {
namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t s = 1000 * ms;
constexpr std::int64_t period = 5 * ms;
constexpr std::int64_t lead = 2 * period;
constexpr std::int64_t most = s + lead;
constexpr std::int64_t stamp_zero = 1'700'000'000 * s;

/// A pipe: stamp(time sent) and delay(time of arrival) of a line.
struct Pipe {
  std::string name;
  std::function<std::int64_t(std::int64_t)> stamp;
  std::function<std::int64_t(std::int64_t)> delay = [](std::int64_t) { return 0; };
  std::int64_t cycle = 10 * ms;
};

struct Moves {
  int count = 0;
  std::int64_t lag = 0;  ///< release time of an undelayed line minus its arrival, at the end
};

Moves play(const Pipe& pipe, std::int64_t duration) {
  LogClock clock(0, period);
  Arrivals arrivals(clock, lead, most);
  Moves moves;
  for (std::int64_t now = s; now < s + duration; now += pipe.cycle) {
    const std::int64_t sent = now - pipe.delay(now);
    const std::int64_t stamp = stamp_zero + pipe.stamp(sent);
    clock.start(stamp, now + lead);
    moves.count += arrivals.take(stamp, now) != 0 ? 1 : 0;
    moves.lag = stamp_zero + pipe.stamp(now) - *clock.offset_ns() - now;
  }
  return moves;
}

std::int64_t same(std::int64_t t) {
  return t;
}
auto stepped(std::int64_t by) {
  return [by](std::int64_t t) { return t < 5 * s ? t : t + by; };
}
auto at_rate(double rate) {
  return [rate](std::int64_t t) { return std::llround(rate * static_cast<double>(t)); };
}

TEST(Arrivals, FollowAClockThatIsSteppedOrRunsAtAnotherRate) {
  for (const std::int64_t by : {-1000 * ms, -300 * ms, -30 * ms, 30 * ms, 300 * ms, 900 * ms}) {
    const Moves moves = play({"step", stepped(by)}, 6 * s);  // settles within two seconds
    EXPECT_EQ(moves.count, 1) << by;
    EXPECT_GE(moves.lag, -period) << by;
    EXPECT_LE(moves.lag, lead + 2 * period) << by;
  }
  for (const double rate : {0.95, 0.98, 0.99, 0.999, 1.001, 1.01, 1.02}) {
    const Moves moves = play({"rate", at_rate(rate)}, 60 * s);
    EXPECT_GT(moves.count, 3) << rate;
    EXPECT_GE(moves.lag, -100 * ms) << rate;
    EXPECT_LE(moves.lag, lead + 3 * period) << rate;
  }
}

TEST(Arrivals, KeepTheClockWhileLinesAreDelayed) {
  std::mt19937 random(7);
  const auto jitter = [&random](std::int64_t most_ns) {
    return [&random, most_ns](std::int64_t) {
      return std::uniform_int_distribution<std::int64_t>(0, most_ns)(random);
    };
  };
  const auto caught_up = [](std::int64_t stalled, double speed) {
    // No lines for a time, then a backlog whose delay shrinks by `speed` seconds a second.
    return [=](std::int64_t t) {
      const std::int64_t into = (t - s) % (10 * s) - 5 * s;
      const double left = static_cast<double>(stalled) - speed * static_cast<double>(into);
      return into < 0 ? 0 : std::max<std::int64_t>(0, std::llround(left));
    };
  };
  const Pipe pipes[]{
      {"exact", same},
      {"jitter", same, jitter(8 * ms)},
      {"a stall of 0.5 s, and a backlog", same, caught_up(500 * ms, 1.0)},
      {"a stall of 5 s, and a slow backlog", same, caught_up(5 * s, 2.0)},
      {"single lines held up", same,
       [](std::int64_t t) { return t / ms % 100 == 50 ? 400 * ms : 0; }},
  };
  for (const Pipe& pipe : pipes) {
    const Moves moves = play(pipe, 60 * s);
    EXPECT_EQ(moves.count, 0) << pipe.name;
  }
  // Large jitter may move the clock while the first lines come, but not continually.
  EXPECT_LE(play({"much jitter", same, jitter(40 * ms)}, 60 * s).count, 3);
}

TEST(Arrivals, KeepTheClockWhileAnotherPipeIsInTime) {
  LogClock clock(0, period);
  Arrivals prompt(clock, lead, most);
  Arrivals late(clock, lead, most);
  int moves = 0;
  for (std::int64_t now = s; now < 20 * s; now += 10 * ms) {
    clock.start(stamp_zero + now, now + lead);
    moves += prompt.take(stamp_zero + now, now) != 0 ? 1 : 0;
    moves += late.take(stamp_zero + now - 80 * ms, now) != 0 ? 1 : 0;
  }
  EXPECT_EQ(moves, 0);
}

// Steps of the clock that stamps a live log ----------------------------------------------------

TEST(LiveStamps, DistinguishClockStepsFromPauses) {
  using Input = LiveStamps::Input;
  struct Frame {
    std::int64_t stamp;  ///< after the stamp of the frame before
    std::int64_t now;    ///< after its arrival
    std::optional<std::int64_t> step;
  };
  struct {
    Input input;
    std::vector<std::vector<Frame>> sequences;  ///< each after ten frames at intervals of 10 ms
  } const cases[]{
      {Input::waited_for,
       {{{3600 * s, 0, 3600 * s}},
        {{-7200 * s, 0, -7200 * s}},
        {{2 * s, 0, 2 * s}},
        {{3600 * s, 3600 * s, {}}},                                    // a pause
        {{10 * ms, 20 * s, {}}, {10 * ms, 0, {}}, {-s / 2, 0, {}}}}},  // kept back, out of order
      {Input::ready, {{{3600 * s, 0, {}}, {-3600 * s, 0, {}}}}},       // a log that is piped in
  };
  for (const auto& [input, sequences] : cases) {
    LiveStamps stamps;
    std::int64_t stamp = stamp_zero;
    std::int64_t now = 5000 * s;
    stamps.read(Input::waited_for);  // waits for the pipe to open
    for (const auto& frames : sequences) {
      for (int i = 0; i < 10; ++i) {
        stamps.read(input);
        EXPECT_FALSE(stamps.step(stamp += 10 * ms, now += 10 * ms));
      }
      for (const Frame& frame : frames)
        EXPECT_EQ(stamps.step(stamp += frame.stamp, now += frame.now), frame.step) << frame.stamp;
    }
  }
  LiveStamps first;
  for (int i = 0; i < 8; ++i) first.read(Input::waited_for);
  EXPECT_FALSE(first.step(stamp_zero, 5000 * s));
}

}  // namespace
}  // namespace odomd::can::arrivals_test
