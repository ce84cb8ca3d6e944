// Strict CSV, and the progress line.
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <limits>

#include "base/file_descriptor.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/cli/csv.hpp"
#include "tools/cli/output.hpp"

namespace odomd::tools::cli_test {
namespace {

// Reads the columns "a" and, if present, "b".
std::vector<double> column_a(const std::string& text, LastLine last = LastLine::keep_whole,
                             std::vector<std::string>* warnings = nullptr) {
  std::istringstream input{text};
  CsvReader reader{input, "x.csv", {"a", "b"}, last, {.required = 1}};
  std::vector<double> values;
  while (reader.next()) values.push_back(reader.number(0));
  if (warnings != nullptr) *warnings = reader.warnings();
  return values;
}

std::string error_of(const std::string& text) {
  return message_of([&] { (void)column_a(text); });
}

TEST(CsvReader, ReadsColumnsByNameFromTextsOfOtherSystems) {
  using Values = std::vector<double>;
  const std::string padding(5000, ' '), zeros(4092, '0');  // the buffer holds 4096 bytes
  EXPECT_EQ(column_a("c,a\n1,2\n3,4\n"), (Values{2.0, 4.0}));
  for (const std::string& text : {"\xEF\xBB\xBF" + std::string("a, b\r\n 1 ,\t2\r\n\r\n3,4\r\n"),
                                  "a,b\n1," + padding + "2\n3,4\n", "a,b\n1," + zeros + "\n3,4\n"})
    EXPECT_EQ(column_a(text), (Values{1.0, 3.0}));
}

TEST(CsvReader, SaysWhetherAnOptionalColumnExists) {
  std::istringstream with{"a,b\n1,2\n"};
  std::istringstream without{"a\n1\n"};
  EXPECT_TRUE((CsvReader{with, "x", {"a", "b"}, LastLine::keep_whole, {.required = 1}}.has(1)));
  EXPECT_FALSE((CsvReader{without, "x", {"a", "b"}, LastLine::keep_whole, {.required = 1}}.has(1)));
}

TEST(CsvReader, NamesFileLineAndColumnOfAnInvalidNumber) {
  EXPECT_EQ(error_of("a,b\n1,2\nnan,2\n"),
            "x.csv:3: column \"a\": \"nan\" is not a finite number; correct or remove the line");
  for (const char* bad : {"inf", "-inf", "1e999", "1x", "", "0x10", "1 2", "+1", "--1"}) {
    EXPECT_THAT(error_of(std::string{"a,b\n"} + bad + ",2\n"), HasSubstr("x.csv:2: column \"a\""))
        << bad;
  }
}

TEST(CsvReader, RefusesOtherTextWithoutEchoingIt) {
  const std::pair<std::string, const char*> cases[]{
      {"t,b\n1,2\n", "x.csv:1: no column \"a\"; the header is \"t,b\", it needs a"},
      {"", "x.csv: is empty"},
      {"a,b,a\n1,2,3\n", "twice"},
      {"a,b\n1\n", "x.csv:2: 1 fields where the header has 2"},
      {"a,b\n1,2,3\n", "3 fields where the header has 2"},
      {std::string(200'000, 'z'), "longer than 64 KiB"},
      {std::string{"\x1b[31m\0\x07\n", 8}, "x.csv:1: "}};
  for (const auto& [text, says] : cases)
    EXPECT_THAT(error_of(text), AllOf(HasSubstr(says), Not(HasSubstr("\x1b"))));
}

TEST(CsvReader, KeepsOrDropsALastLineWithoutNewlineWithAWarning) {
  using enum LastLine;
  using Values = std::vector<double>;
  const struct {
    std::string text;
    LastLine last;
    Values values;
    const char* warning;
  } cases[]{{"a,b\n1,2\n3", keep_whole, {1.0}, "x.csv:3: the last line is cut off"},
            {"a,b\n1,2\n3,4", keep_whole, {1.0, 3.0}, "the last line has no newline"},
            {"a,b\n1,2\n3,4", drop_unended, {1.0}, "cut off"},
            {"a,b\n1,2\n", drop_unended, {1.0}, nullptr}};
  for (const auto& [text, last, values, warning] : cases) {
    std::vector<std::string> warnings;
    EXPECT_EQ(column_a(text, last, &warnings), values);
    ASSERT_EQ(warnings.size(), warning != nullptr ? 1U : 0U) << text;
    if (!warnings.empty()) {
      EXPECT_THAT(warnings[0], HasSubstr(warning));
    }
  }
}

TEST(CsvReader, ReadsTheLayoutsOfOtherPrograms) {
  std::istringstream input{"of a track; wet\n\"b\"\"\";\"a\"\n# gap\n\"x;y\" ; 1;\n;2\n"};
  CsvReader reader{input,
                   "x.csv",
                   {"a", "b\""},
                   LastLine::keep_whole,
                   {.delimiter = ';', .quote = '"', .comment = '#', .header_line = 2}};
  ASSERT_TRUE(reader.next());
  EXPECT_EQ(reader.number(0), 1.0);
  EXPECT_EQ(reader.text(1), "x;y");
  EXPECT_EQ(reader.place(), "x.csv:4");
  ASSERT_TRUE(reader.next());
  EXPECT_EQ(reader.number(0), 2.0);
  EXPECT_FALSE(reader.next());
}

TEST(ParseSeconds, IsExactToTheNanosecondAndRefusesInvalidTimes) {
  const std::pair<const char*, std::int64_t> cases[]{
      {"1760000000.123456789", 1'760'000'000'123'456'789},
      {"-0.000000001", -1},
      {"0", 0},
      {"000.5", 500'000'000},
      {".5", 500'000'000},
      {"5.", 5'000'000'000},
      {"9223372036.854775807", std::numeric_limits<std::int64_t>::max()},
      {"0.30000000000000004", 300'000'000},
      {"0.29999999999999999", 300'000'000},
      {"0.0000000014", 1},
      {"0.0000000005", 1},
      {"0.00000000049", 0},
      {"0.00000000001", 0},
      {"5e-05", 50'000},
      {"1.5E+1", 15'000'000'000},
      {"1e-400", 0}};
  for (const auto& [text, ns] : cases) EXPECT_EQ(parse_seconds(text), ns) << text;
  for (const char* bad : {"", "-", ".", "e5", "1e", "1e+", "1.2.3", "nan", "inf", "0x1", "1 ", "1s",
                          "9223372036.854775808", "1e10", "1e99999999999", "--1"}) {
    EXPECT_EQ(parse_seconds(bad), std::nullopt) << bad;
  }
}

TEST(AppendSeconds, WritesNineDecimalsAndReadsBack) {
  for (const std::int64_t ns :
       {std::int64_t{0}, std::int64_t{1}, std::int64_t{-1}, std::int64_t{1'760'000'000'005'000'000},
        std::numeric_limits<std::int64_t>::max()}) {
    std::string text;
    append_seconds(text, ns);
    EXPECT_EQ(text.size() - text.find('.'), 10U) << text;
    EXPECT_EQ(parse_seconds(text), ns) << text;
  }
}

// What a terminal receives from a child process that shows two states.
std::string on_a_terminal(unsigned short columns = 80) {
  int master = -1;
  const winsize size{.ws_row = 24, .ws_col = columns, .ws_xpixel = 0, .ws_ypixel = 0};
  const pid_t pid = ::forkpty(&master, nullptr, nullptr, &size);
  if (pid == 0) {
    {
      ProgressLine progress("odom test", WithoutTerminal::nothing);
      progress.show("half done");
      progress.show("at once after it, and so left out");
    }
    ::_exit(0);
  }
  const FileDescriptor terminal{master};
  std::string seen;
  char byte = 0;
  while (::read(terminal.get(), &byte, 1) == 1) seen += byte;
  ::waitpid(pid, nullptr, 0);
  return seen;
}

TEST(ProgressLine, RewritesOneLineOnATerminalAndEndsIt) {
  EXPECT_EQ(on_a_terminal(), "\rhalf done\x1b[K\r\n");
  // The line is cut, because a wrapped line cannot be rewritten.
  EXPECT_EQ(on_a_terminal(6), "\rhalf…\x1b[K\r\n");
}

TEST(ProgressLine, PrintsNothingForShortWorkWithoutATerminal) {
  ::testing::internal::CaptureStderr();
  {
    ProgressLine progress("odom test");
    progress.show("half done");
  }
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace odomd::tools::cli_test
