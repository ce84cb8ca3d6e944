// Logs: complete, truncated, damaged, missing, several at once, and the real drives.
#include "can_protocol/sources/log_reader.hpp"

#include <fstream>

#include "tests/can_protocol/temporary_file.hpp"
#include "tests/gtest.hpp"
#include "tests/recorded_drives.hpp"

namespace odomd::can::log_reader_test {
namespace {

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

TEST(LogReader, KeepsTheDriveWhenTheLastLineIsCutOff) {
  const std::string last = "(1.000100) can0 100#0";
  std::vector<std::string> ends{std::string(5000, '\0')};  // of a power cut
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

TEST(LogReader, RefusesWhatIsNoReadableFile) {
  EXPECT_THAT(error_of("/nonexistent/drive.log"),
              AllOf(StartsWith("/nonexistent/drive.log: No such file"), HasSubstr("candump")));
  EXPECT_THAT(error_of("/"), HasSubstr("is a directory"));
}

TEST(LogReader, ReadsLinesAcrossItsBuffersEdge) {
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

TEST(MergedLog, OrdersByStampAndBreaksTiesByTheOrderOfNaming) {
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

TEST(MergedLog, KnowsWhereItsNewestFrameCameFrom) {
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

TEST(RealDrives, ReadToTheLastLineAndWriteBackAsTheyAre) {
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
