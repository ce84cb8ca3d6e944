// A log as a live bus: the mapping of its clock to the tick grid, the hand-over of frames, unusual
// inputs, and an end at any moment.
#include "can_protocol/sources/log_feeder.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include "base/wall_clock.hpp"
#include "can_protocol/sources/log_reader.hpp"
#include "tests/can_protocol/temporary_file.hpp"
#include "tests/gtest.hpp"
#include "tests/process.hpp"

namespace odomd::can::log_feeder_test {
namespace {

constexpr std::int64_t period = 5'000'000;
constexpr std::int64_t never_held_back = INT64_MAX;
constexpr auto timeout = std::chrono::seconds(20);

/// Drains until `count` frames have arrived, the source has ended, or a time limit is reached.
std::vector<Frame> drain(FrameSource& source, std::size_t count,
                         std::int64_t tick_ns = never_held_back) {
  std::vector<Frame> all;
  std::array<Frame, max_frames_per_drain> frames;
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  while (all.size() < count && std::chrono::steady_clock::now() < deadline) {
    const bool ended = source.link() == LinkState::ended;
    const std::size_t got = source.drain(frames, tick_ns, monotonic_now());
    all.insert(all.end(), frames.begin(), frames.begin() + static_cast<std::ptrdiff_t>(got));
    if (ended) break;
    if (got == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return all;
}

void await_end(FrameSource& source) {
  drain(source, SIZE_MAX);
  EXPECT_EQ(source.link(), LinkState::ended);
}

class Fifo {
 public:
  Fifo() { EXPECT_EQ(::mkfifo(path_.c_str(), 0600), 0); }
  void open_writer() { writer_ = FileDescriptor(::open(path_.c_str(), O_WRONLY | O_CLOEXEC)); }
  void close_writer() { writer_ = FileDescriptor(); }
  void write(std::string_view text) const {
    ASSERT_EQ(::write(writer_.get(), text.data(), text.size()), static_cast<ssize_t>(text.size()));
  }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  Scratch place_;
  std::string path_ = place_.path("bus.log");
  FileDescriptor writer_;
};

/// A feeder that plays a file or a pipe; the pipe's writer can be opened.
struct Played {
  explicit Played(const std::string& text, std::int64_t first_tick = 0)
      : file("drive.log", text), clock(first_tick, period) {}
  TemporaryFile file;
  BusNames buses;
  LogClock clock;
  LogFeeder feeder{file.path(), buses, clock};
};

struct Piped {
  Fifo fifo;
  BusNames buses;
  LogClock clock{0, period};
  LogFeeder feeder{fifo.path(), buses, clock};
};

std::string line_at(std::int64_t stamp_ns) {
  std::string text;
  append_candump_line(text, {.time_ns = stamp_ns}, "can0");
  return text;
}

// The clock of the log ----------------------------------------------------------------------------

TEST(AlignedRelease, AlignsMultiplesOfThePeriodWithTicks) {
  for (const std::int64_t first_tick : {0LL, 17LL, 123'456'789LL, 990'000'000'000'001LL})
    for (const std::int64_t stamp : {0LL, 1LL, 69'964'000LL, 1'760'000'000'069'964'000LL})
      for (const std::int64_t earliest : {1LL, 5'000'000LL, 123'456'790LL, 77'777'777'777LL}) {
        const std::int64_t release = aligned_release(stamp, earliest, first_tick, period);
        EXPECT_GE(release, earliest);
        EXPECT_LT(release, earliest + period);
        EXPECT_EQ((release - first_tick - stamp) % period, 0);
      }
}

TEST(LogClock, IsSetByTheFirstFrameAndAdvancedIfThatWasLate) {
  LogClock clock(0, period);
  const std::int64_t stamp = 1'000'000'000'000;
  EXPECT_FALSE(clock.offset_ns());
  EXPECT_EQ(clock.advance(stamp, 0, 1'000'000'000, 0), 0) << "it does not run";
  const std::int64_t late = clock.start(stamp, 140'000'000);
  EXPECT_EQ(late, stamp - 140'000'000);
  EXPECT_EQ(clock.advance(stamp, 135'000'000, 1'000'000'000, 0), 0) << "one period is none";
  EXPECT_EQ(clock.advance(stamp, 39'000'000, 1'000'000'000, 0), 100'000'000);
  EXPECT_EQ(clock.offset_ns(), late + 100'000'000);
  EXPECT_EQ(clock.advance_ns(), 100'000'000);
  EXPECT_EQ(clock.start(stamp, 0), late) << "the base is as it was";
  EXPECT_EQ(clock.advance(stamp, 140'000'000, 1'000'000'000, 0), 0) << "it is never put back";
  EXPECT_EQ(clock.advance(stamp, -2'000'000'000, 1'000'000'000, 0), 0) << "that is no delay";
  clock.restart(stamp, 500'000'000);
  EXPECT_EQ(clock.offset_ns(), stamp - 500'000'000) << "whatever was advanced before";
}

TEST(SmallestDelay, IsNotReportedForAProducerFasterThanRealTime) {
  for (const std::int64_t speed : {2, 10, 100}) {
    SmallestDelay delay;
    for (std::int64_t t = 0; t < 5'000'000'000; t += 1'000'000)
      EXPECT_FALSE(delay.take(t * speed, t)) << speed;
  }
}

// The hand-over -----------------------------------------------------------------------------------

TEST(LogFeeder, KeepsTheSpacingOfStampsAndTheTicksOfAReplay) {
  std::string text;
  std::vector<std::int64_t> stamps;
  for (int i = 0; i < 40; ++i) {
    stamps.push_back(1'760'000'000'003'000'000 + i * 777'000LL);
    text += line_at(stamps.back());
  }
  const std::int64_t first_tick = monotonic_now() + 1'234'567;
  Played log(text, first_tick);
  const auto frames = drain(log.feeder, stamps.size());
  ASSERT_EQ(frames.size(), stamps.size());
  ASSERT_TRUE(log.feeder.log_offset_ns());
  const auto tick_after = [](std::int64_t time, std::int64_t tick_zero) {
    return (time - tick_zero + 1000 * period - 1) / period;
  };
  const std::int64_t replay_zero = (stamps[0] + period - 1) / period * period;
  const std::int64_t first_live = tick_after(frames[0].time_ns, first_tick);
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    EXPECT_EQ(frames[i].time_ns + *log.feeder.log_offset_ns(), stamps[i]);
    EXPECT_EQ(tick_after(frames[i].time_ns, first_tick) - first_live,
              tick_after(stamps[i], replay_zero) - tick_after(stamps[0], replay_zero));
  }
  EXPECT_EQ(log.feeder.counters().received.get(), stamps.size());
}

TEST(LogFeeder, HoldsAFrameBackUntilItsTick) {
  Played log("(1.000000) can0 001#\n(1.005000) can0 002#\n(1.005001) can0 003#\n");
  ASSERT_TRUE(eventually([&] { return log.feeder.log_offset_ns().has_value(); }));
  const std::int64_t tick = 1'005'000'000 - *log.feeder.log_offset_ns();
  ASSERT_EQ(drain(log.feeder, 2, tick).size(), 2U);
  std::array<Frame, 4> frames;
  EXPECT_EQ(log.feeder.drain(frames, tick, tick), 0U);
  EXPECT_NE(log.feeder.link(), LinkState::ended);
  EXPECT_EQ(drain(log.feeder, 1, tick + 1000).size(), 1U);
}

TEST(LogFeeder, ReleasesBackwardAndZeroStampsAtOnce) {
  Played log(
      "(0.000000) can0 001#\n(5000.000000) can0 002#\n(1.000000) can0 003#\n"
      "(0.000000) can0 004#\n");
  const std::int64_t start = monotonic_now();
  const auto frames = drain(log.feeder, 4);
  ASSERT_EQ(frames.size(), 4U);
  EXPECT_EQ(frames[0].time_ns, 0);  // a stamp of zero means none
  EXPECT_GE(frames[1].time_ns, start);
  EXPECT_EQ(frames[2].time_ns - frames[1].time_ns, -4'999'000'000'000);
  EXPECT_EQ(frames[3].time_ns, 0);
}

TEST(LogFeeder, CountsErrorFramesWithoutDeliveringThem) {
  Played log(
      "(1.000000) can0 20000004#0001000000000000\n"
      "(1.000000) can0 20000040#0000000000000000\n(1.000000) can0 002#R\n");
  const auto frames = drain(log.feeder, 2);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].kind, FrameKind::remote);
  EXPECT_EQ(log.feeder.counters().error_frames.get(), 2U);
  EXPECT_EQ(log.feeder.counters().controller_overflows.get(), 1U);
  EXPECT_EQ(log.feeder.counters().bus_offs.get(), 1U);
  EXPECT_EQ(log.feeder.counters().received.get(), 1U);
}

TEST(LogFeeder, CountsLinesWithoutAFrameAndContinues) {
  std::string text = "(1.000000) can0 001#\nnonsense\n(1.000100) can0 0002#\n";
  for (char bus = '1'; bus <= '8'; ++bus) text += std::string("(1.000200) can") + bus + " 003#\n";
  text += "(1.000300) can0 004#\n(1.000400) can0 00";
  Played log(text);
  EXPECT_EQ(drain(log.feeder, 100).size(), 9U);
  EXPECT_EQ(log.feeder.link(), LinkState::ended);
  EXPECT_EQ(log.feeder.counters().malformed.get(), 4U);  // two lines, one bus, the cut end
  EXPECT_THAT(log.feeder.warnings(),
              ElementsAre(HasSubstr("drive.log:2: \"nonsense\" is no frame"),
                          HasSubstr("drive.log:3: expected an identifier"), HasSubstr("can8")));
}

TEST(LogFeeder, GivesEachKindOfWarningOnce) {
  for (const std::string stamp : {"0.000000", "1700000000.250000"}) {
    std::string still;
    for (int i = 0; i < 150; ++i) still += "(" + stamp + ") can0 102#00\n";
    Played log(still);
    await_end(log.feeder);
    EXPECT_THAT(log.feeder.warnings(),
                ElementsAre(HasSubstr("drive.log:150: all 150 frames so far have the time stamp " +
                                      stamp)));
  }
  std::string text = "nonsense\nmore nonsense\n";
  for (int i = 0; i < 600; ++i) text += "(1.000000) can0 102#00\n";
  for (int i = 0; i < 18; ++i)
    text.append("(1.000000) can").append(1, static_cast<char>('1' + i % 9)).append(" 003#\n");
  Played log(text + "nonsense\n");
  await_end(log.feeder);
  EXPECT_THAT(log.feeder.warnings(),
              ElementsAre(HasSubstr("drive.log:1: \"nonsense\" is no frame"),
                          HasSubstr("drive.log:502: all 500"), HasSubstr("can8")));
}

// A pipe ------------------------------------------------------------------------------------------

TEST(LogFeeder, DeliversTheFramesOfAPipeAsTheyArrive) {
  Piped pipe;
  pipe.fifo.open_writer();
  EXPECT_EQ(pipe.feeder.link(), LinkState::up);
  pipe.fifo.write("(1.000000) can0 001#\n(1.00");
  ASSERT_EQ(drain(pipe.feeder, 1).size(), 1U);
  pipe.fifo.write("0200) can0 002#\n");
  const auto second = drain(pipe.feeder, 1);
  ASSERT_EQ(second.size(), 1U);
  EXPECT_EQ(second[0].id, 2U);
  pipe.fifo.close_writer();
  await_end(pipe.feeder);
  EXPECT_EQ(pipe.feeder.counters().malformed.get(), 0U);
}

TEST(LogFeeder, FollowsASteppedClockOfALivePipe) {
  Piped pipe;
  pipe.fifo.open_writer();
  std::int64_t stamp_ms = 1'700'000'000'000;
  const auto live_frames = [&] {
    for (int i = 0; i < 20; ++i, stamp_ms += 5) {
      pipe.fifo.write(line_at(stamp_ms * 1'000'000));
      const auto frames = drain(pipe.feeder, 1);
      ASSERT_EQ(frames.size(), 1U);
      EXPECT_LT(std::abs(frames[0].time_ns - monotonic_now()), 10'000'000'000);
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  };
  live_frames();
  stamp_ms += 3'600'000;
  live_frames();
  stamp_ms -= 7'200'000;
  live_frames();
  EXPECT_EQ(pipe.feeder.counters().clock_steps.get(), 2U);
  EXPECT_THAT(pipe.feeder.warnings(),
              Contains(HasSubstr("the clock of the time stamps was stepped by 35")));
}

TEST(LogFeeder, KnowsTheAgeOfALineWithThisMachinesStamp) {
  const std::int64_t offset = read_clock(CLOCK_REALTIME) - monotonic_now();
  Piped pipe;
  pipe.fifo.open_writer();
  const std::int64_t stamp = monotonic_now() + offset - 700'000'000;
  pipe.fifo.write(line_at(stamp));
  ASSERT_EQ(drain(pipe.feeder, 1).size(), 1U);
  ASSERT_TRUE(pipe.feeder.log_offset_ns());
  EXPECT_NEAR(static_cast<double>(*pipe.feeder.log_offset_ns()), static_cast<double>(offset), 50e6);
}

TEST(LogFeeder, EndsInsideAGapOfYears) {
  Played log("(1.000000) can0 001#\n(8999999999.000000) can0 002#\n");
  EXPECT_EQ(drain(log.feeder, 1).size(), 1U);
  std::array<Frame, 4> frames;
  EXPECT_EQ(log.feeder.drain(frames, never_held_back, monotonic_now()), 0U);
  EXPECT_EQ(log.feeder.link(), LinkState::up);
  EXPECT_TRUE(eventually([&] { return !log.feeder.warnings().empty(); }));
  EXPECT_THAT(log.feeder.warnings(),
              ElementsAre(HasSubstr("drive.log:2: the time stamps jump ahead by 8999999998 s")));
}

const std::string flood = [] {
  std::string text;
  for (int i = 0; i < 20'000; ++i) text += "(1.000000) can0 100#\n";
  return text;
}();

TEST(LogFeeder, EndsAtAnyMoment) {
  const Piped without_a_writer;
  EXPECT_EQ(without_a_writer.feeder.link(), LinkState::up);
  Piped silent;
  silent.fifo.open_writer();
  silent.fifo.write("(1.000000) can0 001#\n(1.0");
  EXPECT_EQ(drain(silent.feeder, 1).size(), 1U);
  const Played with_a_full_ring(flood);
  EXPECT_NE(with_a_full_ring.feeder.link(), LinkState::ended);
}

TEST(LogFeeder, DeliversAFloodThatExceedsItsRing) {
  Played log(flood);
  EXPECT_EQ(drain(log.feeder, 20'000).size(), 20'000U);
  EXPECT_GT(log.feeder.counters().carried_over.get(), 0U);
  std::array<Frame, 1> one;
  EXPECT_EQ(log.feeder.drain(one, never_held_back, 0), 0U);
  await_end(log.feeder);
}

}  // namespace
}  // namespace odomd::can::log_feeder_test
