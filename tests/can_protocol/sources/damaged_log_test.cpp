// What a log may contain besides frames in order: lines that are no frames, damaged lines, files of
// other formats; single wrong stamps, lasting steps and pauses, and stamps that are not times.
#include "can_protocol/sources/log_lines.hpp"

#include <functional>

#include "can_protocol/sources/log_reader.hpp"
#include "tests/can_protocol/temporary_file.hpp"
#include "tests/gtest.hpp"

namespace odomd::can::damaged_log_test {
namespace {

using namespace std::string_literals;

const std::string first = "(1.000000) can0 100#01\n";
const std::string second = "(1.010000) can0 100#02\n";

std::string joined(std::initializer_list<std::string_view> parts) {
  std::string all;
  for (const std::string_view part : parts) all += part;
  return all;
}

struct Outcome {
  std::vector<std::int64_t> stamps;  ///< of the frames
  std::vector<std::string> warnings;
  std::string error;
};

/// Reads the log that open(path, buses) gives.
template <typename Open>
Outcome outcome_of(const std::string& text, const Open& open) {
  const TemporaryFile file("drive.log", text);
  Outcome outcome;
  BusNames buses;
  try {
    auto log = open(file.path(), buses);
    while (const Frame* frame = log.next()) outcome.stamps.push_back(frame->time_ns);
    outcome.warnings = log.warnings();
  } catch (const LogError& error) {
    outcome.error = error.what();
  }
  return outcome;
}

Outcome read(const std::string& text, Damage damage = Damage::left_out) {
  return outcome_of(text, [&](const std::string& path, BusNames& buses) {
    return LogReader(path, buses, damage);
  });
}

// Lines -------------------------------------------------------------------------------------------

TEST(LogLines, SkipsTheLinesThatCanplayerSkips) {
  for (const std::string_view line :
       {"DROPCOUNT: dropped 3 CAN frames on 'can0' socket (total drops 3)", "# lap 3, wet", "; wet",
        "// lap #3", "lap 3", "\tlap", "na\xEFve", "Disabled standard output",
        "(1.005000) can0 45123#81:00:12345678#11223344"}) {
    for (const Damage damage : {Damage::left_out, Damage::refused}) {
      const Outcome outcome = read(joined({first, line, "\n", second}), damage);
      EXPECT_EQ(outcome.stamps.size(), 2U) << line << outcome.error;
      EXPECT_THAT(outcome.warnings, ElementsAre(HasSubstr("drive.log:2: 1 line is no frame")));
    }
  }
  EXPECT_THAT(read(joined({"# a\n", first, "# b\n# c\n"})).warnings,
              ElementsAre(AllOf(HasSubstr(":1: 3 lines are no frames"), HasSubstr("\"# a\""))));
}

TEST(LogLines, ReadsTheFrameBehindAByteOrderMark) {
  const Outcome outcome = read(joined({"\xEF\xBB\xBF", first, second}));
  EXPECT_EQ(outcome.stamps.size(), 2U);
  EXPECT_THAT(outcome.warnings, IsEmpty());
  EXPECT_EQ(read(joined({"\xEF\xBB\xBF# lap 3\n", first, second})).stamps.size(), 2U);
}

TEST(LogLines, CountsDamagedStretchesAndRefusesThemWhenStrict) {
  const std::string zeros(40, '\0');
  struct {
    std::string text;
    std::string warning;
  } const cases[]{
      {joined({first, zeros, "\n(1.005\n", second}),
       ":2: the log is damaged here: 2 lines are left out"},
      {joined({first, zeros, second, second}), ":2: the log is damaged here: 1 line is left out"},
      {joined({first, "(1.005(1.010000) can0 100#02\n", second}),
       ":2: the log is damaged here: 1 line"},
      {joined({first, "00) can0 100#02\n", second}), ":2: the log is damaged here: 1 line is"},
      {joined({first, "(1.00\n", second, "(1.0\n\x1B[3\n", second}),
       ":2: the log is damaged here and in 1 other place: 3 lines"},
      {joined({first, "(1.000000) can0 1000#01\n", second}), ":2: the log is damaged here: 1 line"},
  };
  for (const auto& one : cases) {
    const Outcome outcome = read(one.text);
    EXPECT_GE(outcome.stamps.size(), 2U) << one.text;
    EXPECT_THAT(outcome.warnings,
                ElementsAre(AllOf(HasSubstr(one.warning), HasSubstr("--strict"))));
    const Outcome strict = read(one.text, Damage::refused);
    EXPECT_EQ(strict.stamps.size(), 1U);
    EXPECT_THAT(strict.error, HasSubstr("drive.log:2: expected"));
  }
}

struct Foreign {
  std::string start;
  std::string what;
  std::string way;
};

TEST(LogFormat, NamesTheFormatAndItsConversion) {
  const std::string trc =
      "\n;---+--   ----+----  --+--\n     1)         0.1  Rx         0123  4  64\n";
  const std::vector<Foreign> files{
      {"date Mon Jan 5 10:00:00.000 am 2026\nbase hex  timestamps absolute\n", "ASC", "asc2log"},
      {"LOGG\x90\0\0\0"s, "BLF", "can_logconvert"},
      {";$FILEVERSION=1.1" + trc, "TRC", "can_logconvert"},
      {";$FILEVERSION=2.1\n;$STARTTIME=43008.920986006946\n;$COLUMNS=N,O,T,B,I,d,R,L,D\n", "TRC",
       "can_logconvert"},
      {";##########\n;   C:\\test.trc\n;    CAN activities" + trc, "TRC", "can_logconvert"},
      {"MDF     4.10    CANedge\0"s, "MF4", "can_logconvert"},
      {"\n\r\r\n\x1C\0\0\0"s, "pcapng", "candump -L"},
      {"\xD4\xC3\xB2\xA1\2\0\4\0"s, "pcap", "candump -L"},
      {"\x4D\x3C\xB2\xA1\2\0\4\0"s, "pcap", "candump -L"},
      {"Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2\n166064000,00000123,false,Rx,0,8,1,2\n", "CSV",
       "SavvyCAN"},
      {"timestamp,arbitration_id,extended,remote,error,dlc,data\n", "CSV", "can_logconvert"},
      {"# Logger type: CL2000\nTimestamp;Type;ID;Data\n21T170000123;0;123;64003200\n", "CSV",
       "(seconds) interface id#data"},
      {"***BUSMASTER Ver 3.2.2***\n***PROTOCOL CAN***\n", "BUSMASTER", "asc2log"},
      {"#ROSBAG V2.0\nE\0\0\0"s, "ROS bag", "candump -L vcan0"},
      {"\x89MCAP0\r\n\1"s, "MCAP", "candump -L vcan0"},
      {"SQLite format 3\0"s, "ROS 2", "candump -L vcan0"},
      {"  can0  123   [4]  64 00 32 00\n", "display of candump", "candump -L"},
      {" (1700000000.000100)  can0  123   [4]  64 00 32 00\n", "display of candump", "candump -L"},
      {" (000.000000)  vcan1  18DAF110  [08]  02 10 03 00 00 00 00 00\n", "display of candump",
       "candump -L"},
      {"\x1F\x8B\x08\0"s, "gzip", "zcat FILE | odom ... -"},
      {"\xFD"
       "7zXZ\0"s,
       "xz", "xzcat"},
      {"\x28\xB5\x2F\xFD\4"s, "zstd", "zstdcat"},
      {"BZh91AY&SY", "bzip2", "bzcat"},
      {"PK\3\4\x14\0"s, "zip", "unzip -p"},
      {"\xFF\xFE(\0001\0"s, "UTF-16", "iconv"},
  };
  for (const Foreign& file : files) {
    const auto text = describe_foreign_format(file.start);
    EXPECT_THAT(text.value_or("unknown"), AllOf(HasSubstr(file.what), HasSubstr(file.way)))
        << file.start;
    const Outcome outcome = read(file.start);
    EXPECT_THAT(outcome.error, HasSubstr("drive.log: is ")) << file.start;
  }
  for (const std::string& log : {first, joined({"; a, b, c, d\n", first}),
                                 joined({"# base hex\n", first}), joined({"\xEF\xBB\xBF", first}),
                                 ""s, joined({std::string(100, '\0'), "\n", first}), "(1.0000"s})
    EXPECT_EQ(describe_foreign_format(log).value_or(""), "") << log;
}

// Stamps ------------------------------------------------------------------------------------------

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

Outcome read(const std::vector<Frame>& frames, const FrameSelection& selected = {}) {
  return outcome_of(text_of(frames), [&](const std::string& path, BusNames& buses) {
    return MergedLog(std::vector<std::string>{path}, buses, selected);
  });
}

TEST(LogStamps, LeaveOutFramesWithIsolatedStamps) {
  for (const std::int64_t off : {-3600 * s, -10 * s, 400 * ms, 900 * ms, 10 * s, 3600 * s})
    for (const std::size_t at :
         {std::size_t{0}, std::size_t{1}, std::size_t{200}, count - 2, count - 1})
      for (const std::size_t many : {1U, 2U}) {
        if (at + many > count) continue;
        // At the end of a log, a step forward of less than a second may also be a pause of the bus.
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

TEST(LogStamps, OfUnselectedFramesAreIgnored) {
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

TEST(LogStamps, RefuseTimesSinceThePreviousFrame) {
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
}  // namespace odomd::can::damaged_log_test
