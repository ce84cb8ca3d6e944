// Lines that are not frames, damaged lines, and files of other formats: the same offline and live.
#include "can_protocol/sources/log_lines.hpp"

#include "can_protocol/sources/log_format.hpp"
#include "can_protocol/sources/log_reader.hpp"
#include "tests/can_protocol/temporary_file.hpp"
#include "tests/gtest.hpp"

namespace odomd::can::log_lines_test {
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
  std::size_t frames = 0;
  std::vector<std::string> warnings;
  std::string error;
};

Outcome read(const std::string& text, Damage damage = Damage::left_out) {
  const TemporaryFile file("drive.log", text);
  Outcome outcome;
  BusNames buses;
  try {
    LogReader reader(file.path(), buses, damage);
    while (reader.next()) ++outcome.frames;
    outcome.warnings = reader.warnings();
  } catch (const LogError& error) {
    outcome.error = error.what();
  }
  return outcome;
}

TEST(LogLines, PassesOverWhatCanplayerPassesOver) {
  for (const std::string_view line :
       {"DROPCOUNT: dropped 3 CAN frames on 'can0' socket (total drops 3)", "# lap 3, wet", "; wet",
        "// lap #3", "lap 3", "\tlap", "na\xEFve", "Disabled standard output",
        "(1.005000) can0 45123#81:00:12345678#11223344"}) {
    for (const Damage damage : {Damage::left_out, Damage::refused}) {
      const Outcome outcome = read(joined({first, line, "\n", second}), damage);
      EXPECT_EQ(outcome.frames, 2U) << line << outcome.error;
      EXPECT_THAT(outcome.warnings, ElementsAre(HasSubstr("drive.log:2: 1 line is no frame")));
    }
  }
  EXPECT_THAT(read(joined({"# a\n", first, "# b\n# c\n"})).warnings,
              ElementsAre(AllOf(HasSubstr(":1: 3 lines are no frames"), HasSubstr("\"# a\""))));
}

TEST(LogLines, ReadsTheFrameBehindAByteOrderMark) {
  const Outcome outcome = read(joined({"\xEF\xBB\xBF", first, second}));
  EXPECT_EQ(outcome.frames, 2U);
  EXPECT_THAT(outcome.warnings, IsEmpty());
  EXPECT_EQ(read(joined({"\xEF\xBB\xBF# lap 3\n", first, second})).frames, 2U);
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
    EXPECT_GE(outcome.frames, 2U) << one.text;
    EXPECT_THAT(outcome.warnings,
                ElementsAre(AllOf(HasSubstr(one.warning), HasSubstr("--strict"))));
    const Outcome strict = read(one.text, Damage::refused);
    EXPECT_EQ(strict.frames, 1U);
    EXPECT_THAT(strict.error, HasSubstr("drive.log:2: expected"));
  }
}

struct Foreign {
  std::string start;
  std::string what;
  std::string way;
};

TEST(LogFormat, NamesWhatTheFileIsAndTheWayToACandumpLog) {
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

}  // namespace
}  // namespace odomd::can::log_lines_test
