// The candump grammar: all forms of a frame, read and written, and the errors of invalid lines.
// Logs: complete, truncated, damaged, missing, several together, and the real drives.
#include "can_protocol/sources/log_reader.hpp"

#include <fmt/format.h>

#include <fstream>

#include "can_protocol/sources/candump.hpp"
#include "tests/can_protocol/temporary_file.hpp"
#include "tests/recorded_drives.hpp"
#include "tests/table.hpp"

namespace odomd::can::log_reader_test {
namespace {

CandumpLine good(std::string_view text) {
  CandumpLine line = parse_candump_line(text);
  EXPECT_TRUE(line.good()) << text << ": expected " << line.expected << " at " << line.column;
  return line;
}

/// "time [ns] interface: s|x (identifier format) identifier kind length bytes", and the flags of
/// FD.
std::string description(const CandumpLine& line) {
  const Frame& frame = line.frame;
  std::string text = fmt::format(
      "{} {}: {}{:X} {} {}", frame.time_ns, line.interface,
      frame.format == IdFormat::extended ? 'x' : 's', frame.id,
      std::array{"data", "remote", "error"}.at(static_cast<std::size_t>(frame.kind)), frame.length);
  if (frame.kind != FrameKind::remote)
    for (const std::uint8_t byte : frame.payload()) text += fmt::format(" {:02X}", byte);
  if (frame.protocol == FrameProtocol::fd) text += fmt::format(" fd {}", frame.fd_flags);
  return text;
}

TEST(Candump, ReadsEveryKindOfFrame) {
  for_each_row(R"(
(1760000000.069964) can0 120#0400A0FF -> 1760000000069964000 can0: s120 data 4 04 00 A0 FF
(1760000000.069964123) can0 120# -> 1760000000069964123 can0: s120 data 0
(0000000000.000000001) can0 120# -> 1 can0: s120 data 0
(1.000000) can0 00000123#01 -> 1000000000 can0: x123 data 1 01
(1.000000) can0 18DAF110#01 -> 1000000000 can0: x18DAF110 data 1 01
(1.000000) can0 7FF#01 -> 1000000000 can0: s7FF data 1 01
(1.000000) can0 123#R -> 1000000000 can0: s123 remote 0
(1.000000) can0 123#R4 -> 1000000000 can0: s123 remote 4
(1.000000) can0 123#R8_9 -> 1000000000 can0: s123 remote 8
(1.000000) can0 20000004#0004000000000000 -> 1000000000 can0: s4 error 8 00 04 00 00 00 00 00 00
(1.000000) can0 123##1AABBCC -> 1000000000 can0: s123 data 3 AA BB CC fd 1
(1.000000) can0 123##0 -> 1000000000 can0: s123 data 0 fd 0
# Newer kernels also set the flag "this is CAN FD" (4).
(1.000000) can0 123##7AA -> 1000000000 can0: s123 data 1 AA fd 3
# What other writers add.
(1.000000) can0 123#1122334455667788_C -> 1000000000 can0: s123 data 8 11 22 33 44 55 66 77 88
(1.000000) can0 123#11.22.33 -> 1000000000 can0: s123 data 3 11 22 33
(1.000000) can0 123#ab R -> 1000000000 can0: s123 data 1 AB
 (1.000000) vcan-front.1 7ff#   -> 1000000000 vcan-front.1: s7FF data 0
)",
               [](const std::string& text, const std::string& expected) {
                 EXPECT_EQ(description(good(text)), expected) << text;
               });
  EXPECT_EQ(description(good("(1.000000)  can0\t123##0ab T\r")),
            "1000000000 can0: s123 data 1 AB fd 0");
  EXPECT_EQ(good("(1.000000) can0 12345678##3" + std::string(128, 'E')).frame.length, 64);
}

TEST(Candump, ReportsWhatWasExpectedAndWhere) {
  const auto expect_bad = [](const std::string& text, const std::string& column_and_expected) {
    const CandumpLine line = parse_candump_line(text);
    EXPECT_FALSE(line.good()) << text;
    const std::size_t blank = column_and_expected.find(' ');
    EXPECT_EQ(std::to_string(line.column), column_and_expected.substr(0, blank)) << text;
    EXPECT_THAT(std::string(line.expected), HasSubstr(column_and_expected.substr(blank + 1)));
  };
  for_each_row(R"(
 -> 1 '('
1.000000 can0 123# -> 1 '('
(-1.000000) can0 123# -> 2 seconds
(1) can0 123# -> 3 decimals
(1.5) can0 123# -> 5 6 or 9 decimals
(1.0000000) can0 123# -> 11 6 or 9 decimals
(1.0000000000) can0 123# -> 14 6 or 9 decimals
(9000000001.000000) can0 123# -> 11 2255
(99999999999999999999999.000000) can0 123# -> 11 2255
(1.000000 can0 123# -> 10 ')'
(1.000000)can0 123# -> 11 space
(1.000000)  -> 12 interface
(1.000000) can0 -> 16 space
(1.000000) can0  -> 17 identifier
(1.000000) can0 12#00 -> 19 3 or 8
(1.000000) can0 1234#00 -> 21 3 or 8
(1.000000) can0 123456789#00 -> 25 3 or 8
(1.000000) can0 800#00 -> 17 7FF
(1.000000) can0 40000000#00 -> 17 1FFFFFFF
(1.000000) can0 123#0 -> 22 second digit
(1.000000) can0 123#0G -> 22 second digit
(1.000000) can0 123#00 junk -> 24 end of the line
(1.000000) can0 123#112233445566778899 -> 37 longer
(1.000000) can0 123#R9 -> 22 end of the line
(1.000000) can0 123## -> 22 flags
(1.000000) can0 123##0112233445566778899 -> 41 12, 16
(1.000000) can0 123#1122334455667788_8 -> 38 9 to F
(1.000000) can0 20000004##000 -> 27 error frame
)",
               expect_bad);
  expect_bad(std::string("(1.000000) can0 123#00\0", 23), "23 end of the line");
}

TEST(Candump, WritesWhatItReads) {
  for (const std::string_view text :
       {"(1760000000.069964) can0 120#0400A0FF\n", "(1760000000.000000) can1 18DAF110#\n",
        "(0000046408.584930) vcan0 123#R\n", "(1760000000.000001) can0 123#R4\n",
        "(1760000000.000000) can0 20000004#0004000000000000\n",
        "(1760000000.000000) can0 123##1AABBCC\n", "(1760000000.000000) can0 12345678##0\n"}) {
    const CandumpLine line = good(text.substr(0, text.size() - 1));
    std::string written;
    append_candump_line(written, line.frame, line.interface);
    EXPECT_EQ(written, text);
  }
}

TEST(Candump, WritesMicrosecondsOrNanoseconds) {
  Frame frame;
  frame.time_ns = 1'760'000'000'999'999'999;
  frame.id = 0x7FF;
  std::string written;
  append_candump_line(written, frame, "can0", StampDecimals::nine);
  append_candump_line(written, frame, "can0", StampDecimals::six);
  EXPECT_EQ(written,
            "(1760000000.999999999) can0 7FF#\n"
            "(1760000000.999999) can0 7FF#\n");
}

// Logs --------------------------------------------------------------------------------------------

std::vector<Frame> read_all(const std::string& path, BusNames& buses) {
  LogReader reader(path, buses, Damage::refused);
  std::vector<Frame> frames;
  while (const auto* frame = reader.next()) frames.push_back(*frame);
  return frames;
}

std::string error_of(const std::string& path) {
  BusNames buses;
  try {
    read_all(path, buses);
  } catch (const LogError& error) {
    EXPECT_THAT(error.what(), Not(HasSubstr("\n")));
    return error.what();
  }
  return "no error";
}

std::string error_of_content(std::string_view content) {
  const TemporaryFile file("drive.log", content);
  const std::string text = error_of(file.path());
  EXPECT_THAT(text, StartsWith(file.path()));
  return text.substr(std::min(text.size(), file.path().size()));
}

TEST(LogReader, NumbersTheBusesInTheOrderOfTheirAppearance) {
  // Empty lines and carriage returns are passed over.
  const TemporaryFile file("drive.log",
                           "\n\r\n(1.000000) can1 100#01\r\n  \n(1.000100) can0 100#02\n"
                           "(1.000200) can1 100#");
  BusNames buses;
  std::vector<int> numbers;
  for (const Frame& frame : read_all(file.path(), buses)) numbers.push_back(frame.bus);
  EXPECT_THAT(numbers, ElementsAre(0, 1, 0));
  EXPECT_THAT(buses.all(), ElementsAre("can1", "can0"));
}

TEST(LogReader, AcceptsATruncatedLastLineWithAWarning) {
  const std::string last = "(1.000100) can0 100#0";
  std::vector<std::string> ends{std::string(5000, '\0')};  // as after a power cut
  for (std::size_t cut = 1; cut <= last.size(); ++cut) ends.push_back(last.substr(0, cut));
  for (const std::string& end : ends) {
    const TemporaryFile file("drive.log", "(1.000000) can0 100#01\n" + end);
    BusNames buses;
    LogReader reader(file.path(), buses);
    std::size_t frames = 0;
    while (reader.next()) ++frames;
    const bool parsable = end == "(1.000100) can0 100#";
    EXPECT_EQ(frames, parsable ? 2U : 1U) << end;
    if (!parsable) {
      EXPECT_THAT(reader.warnings(),
                  ElementsAre(HasSubstr("drive.log:2: the last line is cut off")));
    }
  }
}

TEST(LogReader, RefusesALogWithoutAFrameOrWithADamagedLine) {
  EXPECT_THAT(
      error_of_content("(1.000000) can0 100#01\n(1.000000) can0 1000#01\n"),
      AllOf(StartsWith(":2: expected"), HasSubstr("column 21"), HasSubstr("a line looks like")));
  EXPECT_THAT(error_of_content(""), HasSubstr("contains no frame"));
  EXPECT_THAT(error_of_content("\n\n"), HasSubstr("contains no frame"));
  EXPECT_THAT(error_of_content("(1.0000"), StartsWith(":1: expected 6 or 9 decimals"));
  EXPECT_THAT(error_of_content("\ngarbage"), StartsWith(":2: \"garbage\" is no frame; a line"));
  std::string garbage;
  for (unsigned i = 0; i < 400'000; ++i) garbage.push_back(static_cast<char>(i * i >> 3U));
  EXPECT_THAT(error_of_content(garbage), HasSubstr(":1: expected"));
  EXPECT_THAT(error_of_content(std::string(400'000, 'x')), HasSubstr(":1: \"xxx"));
  std::string buses;
  for (char bus = '0'; bus <= '8'; ++bus) buses += std::string("(1.000000) can") + bus + " 100#\n";
  EXPECT_THAT(error_of_content(buses),
              AllOf(StartsWith(":9: "), HasSubstr("can8"), HasSubstr("at most 8")));
}

TEST(LogReader, RefusesUnreadableFiles) {
  EXPECT_THAT(error_of("/nonexistent/drive.log"),
              AllOf(StartsWith("/nonexistent/drive.log: No such file"), HasSubstr("candump")));
  EXPECT_THAT(error_of("/"), HasSubstr("is a directory"));
}

TEST(LogReader, ReadsLinesAcrossTheEdgeOfItsBuffer) {
  std::string text;
  constexpr std::uint32_t frames = 20'000;  // fills several buffers
  for (std::uint32_t i = 0; i < frames; ++i)
    append_candump_line(
        text,
        {.time_ns = i * 1'000'000LL, .id = i % 0x7FF, .length = static_cast<std::uint8_t>(i % 9)},
        "can0");
  const TemporaryFile file("drive.log", text);
  BusNames buses;
  std::string written;
  for (const Frame& frame : read_all(file.path(), buses))
    append_candump_line(written, frame, "can0");
  EXPECT_TRUE(written == text) << written.size();
}

TEST(MergedLog, OrdersByStampThenByTheOrderOfTheLogs) {
  const TemporaryFile first("first.log",
                            "(1.000000) can0 001#\n(3.000000) can0 003#\n(3.000000) can0 004#\n");
  const TemporaryFile second("second.log",
                             "(0.500000) can1 000#\n(1.000000) can1 002#\n(3.000000) can1 005#\n"
                             "(9.000000) can1 006");
  BusNames buses;
  const std::vector<std::string> paths{first.path(), second.path()};
  MergedLog log(paths, buses);
  for (std::uint32_t id = 0; id < 6; ++id) {
    const auto* frame = log.next();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->id, id);
  }
  EXPECT_FALSE(log.next());
  ASSERT_EQ(log.warnings().size(), 1U);
  EXPECT_THAT(log.warnings()[0], HasSubstr("second.log:4"));
}

TEST(MergedLog, KnowsThePositionOfItsNewestFrame) {
  const TemporaryFile a("a.log", "(1.000000) can0 001#\n\n(3.000000) can0 003#\n");
  const TemporaryFile b("b.log", "(2.000000) can0 002#\n");
  BusNames buses;
  MergedLog log(std::vector<std::string>{a.path(), b.path()}, buses);
  EXPECT_EQ(log.position(), "");
  for (const std::string& expected : {a.path() + ":1: ", b.path() + ":1: ", a.path() + ":3: "}) {
    ASSERT_TRUE(log.next());
    EXPECT_EQ(log.position(), expected);
  }
}

TEST(RealDrives, AreReadCompletelyAndWrittenBackUnchanged) {
  std::vector<std::string> drives(recorded::drives.begin(), recorded::drives.end());
  drives.insert(drives.end(), recorded::drives_with_config.begin(),
                recorded::drives_with_config.end());
  if (!recorded::at_hand(drives.size())) return;
  for (const std::string& drive : drives) {
    const auto path = recorded::folder(drive) / "drive.log";
    BusNames buses;
    LogReader reader(path.string(), buses);
    std::ifstream lines(path);
    std::string line;
    std::string written;
    while (std::getline(lines, line)) {
      const auto* frame = reader.next();
      ASSERT_TRUE(frame) << path;
      written.clear();
      append_candump_line(written, *frame, buses.all()[frame->bus]);
      const std::size_t padding = 10 - std::min<std::size_t>(10, line.find('.') - 1);
      line.insert(1, padding, '0');
      ASSERT_EQ(written, line + "\n") << path;
    }
    EXPECT_FALSE(reader.next());
    EXPECT_THAT(reader.warnings(), IsEmpty());
  }
}

}  // namespace
}  // namespace odomd::can::log_reader_test
