// Single wrong stamps, lasting steps and pauses, and stamps that are not times.
#include "can_protocol/sources/log_stamps.hpp"

#include <functional>

#include "can_protocol/sources/candump.hpp"
#include "can_protocol/sources/log_reader.hpp"
#include "tests/can_protocol/temporary_file.hpp"
#include "tests/gtest.hpp"

namespace odomd::can::log_stamps_test {
namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t s = 1000 * ms;
constexpr std::int64_t epoch = 1'760'000'000 * s;
constexpr std::size_t count = 400;

/// Frames every 5 ms; each contains its number.
std::vector<Frame> log_of(const std::function<std::int64_t(std::size_t)>& stamp_of) {
  std::vector<Frame> log(count);
  for (std::size_t i = 0; i < count; ++i)
    log[i] = {.time_ns = stamp_of(i), .id = 0x100, .length = 2};
  return log;
}
std::int64_t usual(std::size_t i) {
  return epoch + static_cast<std::int64_t>(i) * 5 * ms;
}

std::string text_of(const std::vector<Frame>& frames) {
  std::string text;
  for (const Frame& frame : frames) append_candump_line(text, frame, "can0");
  return text;
}

struct Outcome {
  std::vector<std::int64_t> stamps;
  std::vector<std::string> warnings;
  std::string error;
};

Outcome read(const std::vector<Frame>& frames, const FrameSelection& selected = {}) {
  const TemporaryFile file("drive.log", text_of(frames));
  Outcome outcome;
  BusNames buses;
  try {
    MergedLog log(std::vector<std::string>{file.path()}, buses, selected);
    while (const Frame* frame = log.next()) outcome.stamps.push_back(frame->time_ns);
    outcome.warnings = log.warnings();
  } catch (const LogError& error) {
    outcome.error = error.what();
  }
  return outcome;
}

TEST(LogStamps, LeaveOutFramesWhoseStampsStandAlone) {
  for (const std::int64_t off : {-3600 * s, -10 * s, 400 * ms, 900 * ms, 10 * s, 3600 * s})
    for (const std::size_t at :
         {std::size_t{0}, std::size_t{1}, std::size_t{200}, count - 2, count - 1})
      for (const std::size_t many : {1U, 2U}) {
        if (at + many > count) continue;
        // At the end, such a step may as well be a pause of the bus of less than a second.
        if (at + many == count && off > 0 && off < s) continue;
        const Outcome outcome = read(
            log_of([&](std::size_t i) { return usual(i) + (i >= at && i < at + many ? off : 0); }));
        EXPECT_EQ(outcome.stamps.size(), count - many)
            << off << " at " << at << " " << outcome.error;
        EXPECT_THAT(outcome.warnings,
                    ElementsAre(HasSubstr("drive.log:" + std::to_string(at + 1) + ": the stamp")));
      }
}

TEST(LogStamps, KeepStepsPausesAndSmallDisorder) {
  const std::pair<std::string, std::function<std::int64_t(std::size_t)>> logs[]{
      {"step ahead", [](std::size_t i) { return usual(i) + (i < 200 ? 0 : 10 * s); }},
      {"small step ahead", [](std::size_t i) { return usual(i) + (i < 200 ? 0 : 300 * ms); }},
      {"step back", [](std::size_t i) { return usual(i) - (i < 200 ? 0 : 10 * s); }},
      {"hours", [](std::size_t i) { return usual(i) + (i < 200 ? 0 : 7200 * s); }},
      {"mixed order", [](std::size_t i) { return usual(i) + (i % 2 == 0 ? 0 : 12 * ms); }},
      {"two adapters", [](std::size_t i) { return usual(i) + (i % 5 == 0 ? 150 * ms : 0); }},
      {"last after a pause", [](std::size_t i) { return usual(i) + (i < count - 5 ? 0 : 3 * s); }},
      {"pause after the first", [](std::size_t i) { return usual(i) + (i < 10 ? 0 : 3 * s); }},
      {"one behind", [](std::size_t i) { return usual(i) - (i == 200 ? 500 * ms : 0); }},
      {"slow", [](std::size_t i) { return epoch + static_cast<std::int64_t>(i) * 2 * s; }},
      {"bursts", [](std::size_t i) { return epoch + static_cast<std::int64_t>(i / 20) * 2 * s; }},
      {"from zero", [](std::size_t i) { return static_cast<std::int64_t>(i) * 5 * ms; }},
      {"no stamps between", [](std::size_t i) { return i % 3 == 0 ? 0 : usual(i); }},
  };
  for (const auto& [name, stamp_of] : logs) {
    const Outcome outcome = read(log_of(stamp_of));
    EXPECT_EQ(outcome.stamps.size(), count) << name << outcome.error;
    EXPECT_THAT(outcome.warnings, IsEmpty()) << name;
    for (std::size_t i = 0; i < outcome.stamps.size(); ++i)
      ASSERT_EQ(outcome.stamps[i], stamp_of(i)) << name;
  }
}

TEST(LogStamps, OfUnselectedFramesDoNotCount) {
  std::vector<Frame> frames;
  std::vector<std::int64_t> expected;
  for (std::size_t i = 0; i < count; ++i) {
    for (const std::int64_t off : {-3600 * s, 10 * s, 3600 * s})
      frames.push_back({.time_ns = usual(i) + off, .id = 0x0A2});
    frames.push_back({.time_ns = usual(i), .id = 0x100});
    expected.push_back(usual(i));
  }
  const Outcome outcome = read(frames, [](const Frame& frame) { return frame.id == 0x100; });
  EXPECT_EQ(outcome.stamps, expected);
  EXPECT_THAT(outcome.warnings, IsEmpty());
  EXPECT_THAT(read(frames, [](const Frame& frame) { return frame.id == 0x7FF; }).warnings,
              ElementsAre(HasSubstr("none of its 1600 frames is of a mapped message")));
}

TEST(LogStamps, RefuseTheTimeSinceTheFrameBefore) {
  const std::function<std::int64_t(std::size_t)> logs[]{
      [](std::size_t i) { return i == 0 ? 0 : (i % 2 == 0 ? 4435 : 565) * 1000LL; },
      [](std::size_t i) { return (5000 + static_cast<std::int64_t>(i * i % 7)) * 1000LL; },
      [](std::size_t i) {
        return i % 10 == 0 ? 10 * ms - static_cast<std::int64_t>(i) * 1000 : 90'000;
      },
      [](std::size_t i) {
        return i == 40 ? 12 * s : static_cast<std::int64_t>(i * 7919 % 97) * 50'000;
      },
  };
  for (const auto& stamp_of : logs) {
    EXPECT_THAT(read(log_of(stamp_of)).error,
                AllOf(HasSubstr("time since the frame before"), HasSubstr("candump -L")));
    std::vector<Frame> few = log_of(stamp_of);
    few.resize(100);
    EXPECT_THAT(read(few).error, HasSubstr("time since the frame before"));
  }
}

}  // namespace
}  // namespace odomd::can::log_stamps_test
