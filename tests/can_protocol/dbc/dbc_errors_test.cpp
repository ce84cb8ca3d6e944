// Errors of the DBC reader: file, line, what was expected, what was found, and the fix. Hostile
// databases: the number of warnings and the effort are bounded by the size of the file.
#include "can_protocol/dbc/dbc.hpp"
#include "tests/can_protocol/dbc/parsed.hpp"
#include "tests/scratch.hpp"
#include "tests/table.hpp"

namespace odomd::can::dbc_errors_test {
namespace {

/// Messages in which each signal is the multiplexor of the next one.
std::string nested(int count) {
  std::string text = "BO_ 1 A: 64 X\n";
  for (int i = 0; i < count; ++i)
    text +=
        fmt::format(" SG_ S{} {}M : {}|8@1+ (1,0) [0|0] \"\" X\n", i, i == 0 ? "" : "m0", 8 * i);
  for (int i = 1; i < count; ++i) text += fmt::format("SG_MUL_VAL_ 1 S{} S{} 0-0;\n", i, i - 1);
  return text;
}

// The warnings, or the error.
std::vector<std::string> complaints_about(const std::string& text) {
  try {
    return warnings_of(parse(text));
  } catch (const DbcError& error) {
    return {error.what()};
  }
}

void expect_complaint(const std::string& text, const std::string& error) {
  EXPECT_THAT(complaints_about(text), Contains(AllOf(StartsWith("car.dbc:" + error),
                                                     HasSubstr("; "),  // the fix
                                                     Not(HasSubstr("\n")))))
      << text;
}

TEST(DbcErrors, NameFileLineAndWhatWasExpected) {
  for_each_row(R"(
[vehicle]¶mass = 1¶ -> 1: expected a statement such as BO_
¶ SG_ S : 0|8@1+ (1,0) [0|0] "" X¶ -> 2: expected a message (BO_) before the first signal, found 'S'
BOO_ 1 A: 8 X¶ SG_ S : 0|8@1+ (1,0) [0|0] "" X¶ -> 1: expected a statement such as BO_, SG_, CM_ or VAL_, found
  'BOO_'
BO_ 1 A 8 X¶ -> 1: expected ':' after the message's name, found '8'
BO_ A: 8 X¶ -> 1: expected the message's identifier, found 'A'
BO_ 1 2: 8 X¶ -> 1: expected the message's name, found '2'
BO_ 1 A: -> 1: expected the message's length in bytes, found end of file
)",
               expect_complaint);
  const auto expect_in_message = [](const std::string& statements, const std::string& error) {
    expect_complaint("BO_ 1 A: 8 X\n" + statements, error);
  };
  for_each_row(R"(
CM_ BO_ 1 "abc¶def -> 2: expected '"' that closes the text begun here
VAL_ 1 S 0 "a" 1 -> 2: expected the value's name in quotes, found end of
VAL_ 1 S 0 "a" -> 2: expected ';' at the end of VAL_, found end of file
VAL_ 1 S 0 "a 1 "b" ;¶CM_ BO_ 1 "text";¶ -> 2: expected a raw value, found 'b'
VAL_ 1 S 0 "a ;¶CM_ BO_ 1 "text";¶ -> 2: expected '"' that closes the text begun here, found another statement
BO_TX_BU_ 1 : A, -> 2: expected ';' at the end of BO_TX_BU_, found end of file
BA_ "GenMsgCycleTime" BO_ 1 "fast";¶ -> 2: expected the cycle time in milliseconds, found "fast"
CM_ SG_ 1 S text;¶ -> 2: expected the comment in quotes, found 'text'
 SG_ S mX : 0|8@1+ (1,0) [0|0] "" X¶ -> 2: expected ':' or a multiplexing (M, m0, m0M) after the signal's name,
  found 'mX'
 SG_ S m0 : 0|16@1+ (1,0) [0|0] "" X¶SG_MUL_VAL_ 1 S M 1-1;¶ -> 3: expected the one multiplexor of signal 'S',
  found 'M'
 SG_ S m0M : 0|4@1+ (1,0) [0|0] "" X¶ SG_ T m0M : 4|4@1+ (1,0) [0|0] "" X¶SG_MUL_VAL_ 1 S T 1-1;¶SG_MUL_VAL_ 1 T S
  1-1;¶ -> 2: expected a multiplexor above signal 'S', found a cycle
 SG_ S M : 0|4@1+ (1,0) [0|0] "" X¶ SG_ T M : 4|4@1+ (1,0) [0|0] "" X¶ SG_ U m1 : 8|4@1+ (1,0) [0|0] "" X¶ -> 4:
  expected one multiplexor for signal 'U', found 2 in message 'A'
)",
               expect_in_message);
  for_each_row(R"(
0|8@1+ (1,0) [0| -> 2: expected the signal's maximum, found end of file
0|0@1+ (1,0) [0|0] "" X¶ -> 2: expected the length of signal 'S', 1 to 64 bits, found 0
0|65@1+ (1,0) [0|0] "" X¶ -> 2: expected the signal's length in bits, 1 to 64, found '65'
505|8@1+ (1,0) [0|0] "" X¶ -> 2: expected a start bit from which signal 'S' fits 64 bytes, found '505'
504|2@0+ (1,0) [0|0] "" X¶ -> 2: expected a start bit from which signal 'S' fits 64 bytes, found '504'
0|8@2+ (1,0) [0|0] "" X¶ -> 2: expected byte order and sign, one of 1+ 1- 0+ 0-, found '2+'
0|8@1+ (0,1,0) [0|0] "" X¶ -> 2: expected ')' after the offset, found ','
0|8@1+ (nan,0) [0|0] "" X¶ -> 2: expected the signal's factor, found 'nan'
0|8@1+ (1,1e999) [0|0] "" X¶ -> 2: expected the signal's offset, found '1e999'
0|8@1+ (1,0) [0|0] rad X¶ -> 2: expected the signal's unit in quotes, found 'rad'
0|8@1+ (1,0) [0|0] "rad X¶ -> 2: expected '"' that closes the text begun here, found end of file
0|8@1+ (1,0) [0|0] "rad X¶ SG_ T : 0|8@1+ (1,0) [0|0] "m" X¶ -> 2: expected '"' that closes the text begun here,
  found another statement
0|16@1+ (1,0) [0|0] "" X¶¶SIG_VALTYPE_ 1 S : 1;¶ -> 4: expected 32 bits for the floating-point signal 'S', found 16
0|16@1+ (1,0) [0|0] "" X¶SIG_VALTYPE_ 1 S : 3;¶ -> 3: expected 0 (integer), 1 (float) or 2 (double), found '3'
0|16@1+ (1,0) [0|0] "" X¶SG_MUL_VAL_ 1 S M 3-1;¶ -> 3: expected a range of multiplexor values, found '3-1'
)",
               [&](const std::string& bits, const std::string& error) {
                 expect_in_message(" SG_ S : " + bits, error);
               });
  expect_complaint("BO_ 1 A: 8 X\n\x01\x02", "2: expected text, found byte 1");
  expect_complaint("BO_ 1 A 8 X\n\x01", "1: expected ':' after the message's name");
  expect_complaint("BO_ 1 " + std::string(256, 'A') + ": 8 X\n",
                   "1: expected a name of at most 255 bytes, found 256: 'AAAA");
}

TEST(DbcErrors, RefuseANonNumericIdentifier) {
  for (const std::string_view id : {"0x12", "-", "1.5", "-0x1"})
    EXPECT_THROW((void)parse(fmt::format("BO_ {} A: 8 X\n", id)), DbcError) << id;
}

TEST(DbcErrors, RefuseATruncatedLastLine) {
  const std::string whole =
      "BU_: Engine Vector__XXX\nBO_ 1 A: 8 Engine\n SG_ S : 0|8@1+ (1,0) [0|0] \"m/s\" Vector__XXX";
  EXPECT_EQ(parse(whole).messages.size(), 1U);
  for (const std::string_view end : {"__XXX", "or__XXX", " Vector__XXX"}) {
    const std::string cut = whole.substr(0, whole.size() - end.size());
    EXPECT_THROW((void)parse(cut), DbcError) << cut;
  }
}

TEST(DbcErrors, WarnAboutAPossibleTruncation) {
  EXPECT_THAT(warnings_of(parse("BO_ 1 A: 8 X\n SG_ S : 0|8@1+ (1,0) [0|0] \"\" X")),
              ElementsAre(HasSubstr("car.dbc:2: the file does not end with a line end")));
  EXPECT_THAT(warnings_of(parse("BO_ 1 A: 8 X\nVAL_ 1 S 0 \"a\"\n")),
              ElementsAre(HasSubstr("found end of file"), HasSubstr("names signal 'S'")));
}

TEST(DbcErrors, RefuseDevicesAndMissingFiles) {
  EXPECT_EQ(message_of([] { (void)read_dbc("/dev/zero"); }), "/dev/zero: is a device; name a file");
  for (const char* file : {"/nonexistent/car.dbc", "/", "/dev/null"})
    EXPECT_THROW((void)read_dbc(file), DbcError) << file;
}

TEST(DbcErrors, LimitTheDepthOfMultiplexingToSixteen) {
  EXPECT_EQ(parse(nested(17)).messages[0].signals.size(), 17U);
  expect_complaint(
      nested(18),
      "19: expected at most 16 multiplexors one above the other, found more above signal 'S17'");
}

std::string many_signals(int count, const std::string& multiplexing_of_first) {
  std::string text =
      "BO_ 1 A: 64 X\n SG_ R " + multiplexing_of_first + ": 0|16@1+ (1,0) [0|0] \"\" X\n";
  const bool multiplexed = !multiplexing_of_first.empty();
  for (int i = 0; i < count; ++i)
    text += fmt::format(" SG_ S{} {} : 16|8@1+ (1,0) [0|0] \"\" X\n", i,
                        multiplexed ? fmt::format("m{}", i) : "");
  return text;
}

TEST(DbcErrors, WarnOnceAboutASignalThatOverlapsManyOthers) {
  const auto warnings = warnings_of(parse(many_signals(300, "")));
  EXPECT_EQ(warnings.size(), 299U);
  EXPECT_EQ(warnings.front(), "car.dbc:4: signals 'S0' and 'S1' of message 'A' overlap");
  EXPECT_EQ(warnings.back(),
            "car.dbc:302: signal 'S299' of message 'A' overlaps 'S0' and 298 more");
}

TEST(DbcErrors, DoNotWarnAboutMultiplexedOverlaps) {
  EXPECT_THAT(warnings_of(parse(R"(BO_ 1 A: 8 X
 SG_ Root M : 0|8@1+ (1,0) [0|0] "" X
 SG_ Zero m0 : 8|16@1+ (1,0) [0|0] "" X
 SG_ One m1 : 15|8@0+ (1,0) [0|0] "" X
 SG_ AlsoOne m1 : 14|8@0+ (1,0) [0|0] "" X
)")),
              ElementsAre(HasSubstr("car.dbc:5: signals 'One' and 'AlsoOne'")));
}

TEST(DbcErrors, LimitTheComparisonsWithAWarning) {
  EXPECT_THAT(warnings_of(parse(many_signals(1000, "M "))), IsEmpty());
  EXPECT_THAT(warnings_of(parse(many_signals(20000, "M "))),
              ElementsAre("car.dbc:1: too many signals to compare them all; some may overlap "
                          "without a warning"));
}

TEST(DbcErrors, WarnOnceAboutAFrequentMessageName) {
  std::string text;
  for (int i = 0; i < 300; ++i) text += fmt::format("BO_ {} A: 8 X\n", i);
  EXPECT_EQ(parse(text).warnings.size(), 299U);
}

TEST(DbcErrors, SurviveAnyTruncation) {
  constexpr std::string_view text =
      "BO_ 1 A: 8 X\n SG_ S M : 0|4@1+ (1,0) [0|0] \"u\" X\n"
      " SG_ T m1 : 4|4@0- (.5,0) [0|0] \"\" X\nVAL_ 1 S 1 \"a\" ;\n"
      "SG_MUL_VAL_ 1 T S 1-1;\nCM_ SG_ 1 S \"c\";\nBA_ \"GenMsgCycleTime\" BO_ 1 5;\n";
  int refused = 0;
  for (std::size_t cut = 0; cut < text.size(); ++cut) {
    try {
      (void)parse(text.substr(0, cut));
    } catch (const DbcError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 140);  // the other cuts lie between statements
}

}  // namespace
}  // namespace odomd::can::dbc_errors_test
