// Lines that are no frames, and damaged ones.
#include "can_protocol/sources/log_lines.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "can_protocol/sources/log_reader.hpp"
#include "tests/can_protocol/temporary_file.hpp"

namespace odomd::can::log_lines_test {
namespace {

using namespace std::string_literals;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

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

}  // namespace
}  // namespace odomd::can::log_lines_test
