// The DBC reader: what it accepts, accepts with a warning, or ignores.
#include "can_protocol/dbc/dbc.hpp"
#include "tests/scratch.hpp"
#include "tests/table.hpp"

namespace odomd::can::dbc_test {
namespace {

/// Messages in which each signal is the multiplexor of the next one.
std::string nested(int count) {
  std::string text = "BO_ 1 A: 64 X\n";
  for (int i = 0; i < count; ++i)
    text += " SG_ S" + std::to_string(i) + (i == 0 ? " M : " : " m0M : ") + std::to_string(8 * i) +
            "|8@1+ (1,0) [0|0] \"\" X\n";
  for (int i = 1; i < count; ++i)
    text += "SG_MUL_VAL_ 1 S" + std::to_string(i) + " S" + std::to_string(i - 1) + " 0-0;\n";
  return text;
}

std::vector<std::string> warnings_of(const Database& database) {
  std::vector<std::string> texts;
  for (const Warning& warning : database.warnings) texts.push_back(describe(database, warning));
  return texts;
}

Database parse(std::string_view text) {
  return parse_dbc(text, "car.dbc");
}

TEST(Dbc, ReadsMessagesAndSignals) {
  const Database database = parse(R"(VERSION ""
NS_ :
	CM_
	BA_DEF_
BS_:
BU_: ECU OTHER
BO_ 288 Imu: 6 ECU
 SG_ YawRate : 0|16@1- (0.0005,-1.5) [-16|16] "rad/s" OTHER,ECU
 SG_ AccX : 23|12@0+ (1E-2,0) [0|0] "m/s2" Vector__XXX

BO_ 2147484000 Long: 64 Vector__XXX
)");
  EXPECT_THAT(warnings_of(database), IsEmpty());
  ASSERT_EQ(database.messages.size(), 2U);
  const Message& imu = database.messages[0];
  EXPECT_EQ(imu.name, "Imu");
  EXPECT_EQ(imu.id, 288U);
  EXPECT_EQ(imu.format, IdFormat::standard);
  EXPECT_EQ(imu.protocol, FrameProtocol::classic);
  EXPECT_EQ(imu.length, 6);
  EXPECT_EQ(imu.sender, "ECU");
  EXPECT_EQ(imu.line, 7U);
  ASSERT_EQ(imu.signals.size(), 2U);
  const Signal& yaw_rate = imu.signals[0];
  EXPECT_EQ(yaw_rate.start_bit, 0);
  EXPECT_EQ(yaw_rate.length, 16);
  EXPECT_EQ(yaw_rate.byte_order, ByteOrder::little_endian);
  EXPECT_EQ(yaw_rate.type, ValueType::signed_integer);
  EXPECT_EQ(yaw_rate.scale, 0.0005);
  EXPECT_EQ(yaw_rate.offset, -1.5);
  EXPECT_EQ(yaw_rate.minimum, -16.0);
  EXPECT_EQ(yaw_rate.maximum, 16.0);
  EXPECT_EQ(yaw_rate.unit, "rad/s");
  EXPECT_EQ(imu.signals[1].byte_order, ByteOrder::big_endian);
  EXPECT_EQ(imu.signals[1].type, ValueType::unsigned_integer);
  EXPECT_EQ(imu.signals[1].scale, 0.01);
  EXPECT_EQ(imu.signals[1].line, 9U);
  EXPECT_EQ(database.messages[1].id, 352U);
  EXPECT_EQ(database.messages[1].format, IdFormat::extended);
  EXPECT_EQ(database.messages[1].protocol, FrameProtocol::fd);
  EXPECT_EQ(find_message(database, "Imu"), database.messages.data());
  EXPECT_EQ(find_message(database, "Imi"), nullptr);
  EXPECT_EQ(find_signal(imu, "AccX"), &imu.signals[1]);
}

TEST(Dbc, ReadsFloatsNamesCommentsAndCycleTimes) {
  const Database database = parse(R"(BO_ 1 A: 8 X
 SG_ F : 0|32@1- (1,0) [0|0] "" X
 SG_ I : 32|8@1+ (1,0) [0|0] "" X
BO_ 2 B: 8 X
 SG_ D : 7|64@0- (1,0) [0|0] "" X
BO_ 3 C: 8 X
CM_ BO_ 1 "first
and \"second\" line";
CM_ SG_ 1 I "an integer";
BA_DEF_ BO_ "GenMsgCycleTime" INT 0 65535;
BA_DEF_ BO_ "VFrameFormat" ENUM "StandardCAN","StandardCAN_FD";
BA_DEF_DEF_ "GenMsgCycleTime" 100;
BA_DEF_DEF_ "VFrameFormat" "StandardCAN";
BA_ "GenMsgCycleTime" BO_ 1 20;
BA_ "GenMsgCycleTime" BO_ 2 2.5;
BA_ "VFrameFormat" BO_ 2 1;
VAL_ 1 I 0 "off" 1 "on" -1 "never" ;
SIG_VALTYPE_ 1 F : 1;
SIG_VALTYPE_ 2 D 2;
)");
  EXPECT_THAT(warnings_of(database), IsEmpty());
  EXPECT_EQ(database.messages[0].signals[0].type, ValueType::float32);
  EXPECT_EQ(database.messages[1].signals[0].type, ValueType::float64);
  EXPECT_EQ(database.messages[0].comment, "first\nand \"second\" line");
  EXPECT_EQ(database.messages[0].signals[1].comment, "an integer");
  EXPECT_EQ(database.messages[0].cycle_time_ns, 20'000'000);
  EXPECT_EQ(database.messages[1].cycle_time_ns, 2'500'000);
  EXPECT_EQ(database.messages[2].cycle_time_ns, 100'000'000);
  EXPECT_EQ(database.messages[0].protocol, FrameProtocol::classic);
  EXPECT_EQ(database.messages[1].protocol, FrameProtocol::fd);
  const auto& values = database.messages[0].signals[1].values;
  ASSERT_EQ(values.size(), 3U);
  EXPECT_EQ(values[0].name, "off");
  EXPECT_EQ(values[2].raw, -1);
}

TEST(Dbc, ReadsNestedMultiplexing) {
  const Database database = parse(R"(BO_ 1 A: 8 X
 SG_ Root M : 0|4@1+ (1,0) [0|0] "" X
 SG_ Inner m1M : 8|8@1+ (1,0) [0|0] "" X
 SG_ Simple m0 : 8|16@1+ (1,0) [0|0] "" X
 SG_ Deep m3 : 16|16@1+ (1,0) [0|0] "" X
 SG_ Always : 4|4@1+ (1,0) [0|0] "" X
SG_MUL_VAL_ 1 Simple Root 0-0, 4-6;
SG_MUL_VAL_ 1 Inner Root 1-1;
SG_MUL_VAL_ 1 Deep Inner 3-3,7-9;
)");
  EXPECT_THAT(warnings_of(database), IsEmpty());
  const auto& signals = database.messages[0].signals;
  EXPECT_TRUE(signals[0].is_multiplexor);
  EXPECT_FALSE(signals[0].multiplexor);
  EXPECT_TRUE(signals[1].is_multiplexor);
  EXPECT_EQ(signals[1].multiplexor, 0U);
  EXPECT_EQ(signals[2].multiplexor, 0U);
  ASSERT_EQ(signals[2].selected_by.size(), 2U);
  EXPECT_EQ(signals[2].selected_by[1].first, 4U);
  EXPECT_EQ(signals[2].selected_by[1].last, 6U);
  EXPECT_EQ(signals[3].multiplexor, 1U);
  EXPECT_FALSE(signals[4].multiplexor);
}

TEST(Dbc, TakesSimpleMultiplexingWithoutExtendedStatements) {
  const Database database = parse(R"(BO_ 1 A: 8 X
 SG_ Two m2 : 8|8@1+ (1,0) [0|0] "" X
 SG_ Root M : 0|8@1+ (1,0) [0|0] "" X
)");
  const Signal& two = database.messages[0].signals[0];
  EXPECT_EQ(two.multiplexor, 1U);
  ASSERT_EQ(two.selected_by.size(), 1U);
  EXPECT_EQ(two.selected_by[0].first, 2U);
  EXPECT_EQ(two.selected_by[0].last, 2U);
}

TEST(Dbc, AcceptsIrregularitiesWithAWarning) {
  const Database database = parse(R"(CM_ "comment before the version";
VERSION ""
BO_ 2048 4WD: 2 X
 SG_ 2ND_GEAR : 0|8@1+ (.25,-.5) [0|0] "" X
 SG_ Low : 4|8@1+ (1,0) [0|0] "" X
 SG_ Wide : 12|8@1+ (1,0) [0|0] "" X
VAL_ 2048 Low 0 "off" 1 "on"
CM_ SG_ 2048 "text without signal";
CM_ SG_ 2048 Nothing "of a signal that is not there";
CM_ BO_ 77 "of a message that is not there";
VAL_ 2048 2ND_GEAR 0 "two
lines";
)");
  EXPECT_EQ(database.messages[0].id, 2048U);
  EXPECT_EQ(database.messages[0].format, IdFormat::extended);
  EXPECT_EQ(database.messages[0].comment, "text without signal");
  EXPECT_EQ(database.messages[0].signals[0].scale, 0.25);
  EXPECT_EQ(database.messages[0].signals[0].offset, -0.5);
  EXPECT_EQ(database.messages[0].signals[1].values.size(), 2U);
  EXPECT_EQ(database.messages[0].signals[0].values.at(0).name, "two lines");
  EXPECT_THAT(
      warnings_of(database),
      ElementsAre(HasSubstr("car.dbc:3: the name '4WD' does not start with a letter"),
                  HasSubstr("car.dbc:3: identifier 2048 of message '4WD' has more than 11 bits"),
                  HasSubstr("car.dbc:4: the name '2ND_GEAR' does not start"),
                  HasSubstr("car.dbc:4: the number '.25' has no digit before its point"),
                  HasSubstr("car.dbc:4: the number '-.5' has no digit before its point"),
                  HasSubstr("car.dbc:5: signals '2ND_GEAR' and 'Low' of message '4WD' overlap"),
                  HasSubstr("car.dbc:6: signal 'Wide' ends beyond the 2 bytes"),
                  HasSubstr("car.dbc:7: expected ';' at the end of VAL_, found 'CM_'"),
                  HasSubstr("car.dbc:8: CM_ SG_ names no signal"),
                  HasSubstr("car.dbc:9: CM_ SG_ names signal 'Nothing', which message '4WD'"),
                  HasSubstr("car.dbc:10: CM_ BO_ names message 77"),
                  HasSubstr("is on several lines; joined to one")));
}

TEST(Dbc, WarnsOfASignalThatNoMultiplexorValueSelects) {
  const Database database = parse(R"(BO_ 2147483649 A: 8 X
 SG_ Page M : 0|4@1+ (1,0) [0|0] "" X
 SG_ Low m15 : 8|8@1+ (1,0) [0|0] "" X
 SG_ High m16 : 8|8@1+ (1,0) [0|0] "" X
CM_ BO_ 2147483650 "another";
)");
  EXPECT_THAT(
      warnings_of(database),
      ElementsAre(HasSubstr("car.dbc:4: signal 'High' is never present: multiplexor 'Page'"),
                  HasSubstr("car.dbc:5: CM_ BO_ names message 2147483650,")));
}

TEST(Dbc, DoesNotWarnOfOverlapsThatMultiplexingKeepsApart) {
  const Database database = parse(R"(BO_ 1 A: 8 X
 SG_ Root M : 0|8@1+ (1,0) [0|0] "" X
 SG_ Zero m0 : 8|16@1+ (1,0) [0|0] "" X
 SG_ One m1 : 15|8@0+ (1,0) [0|0] "" X
 SG_ AlsoOne m1 : 14|8@0+ (1,0) [0|0] "" X
)");
  EXPECT_THAT(warnings_of(database),
              ElementsAre(HasSubstr("car.dbc:5: signals 'One' and 'AlsoOne'")));
}

TEST(Dbc, TakesTheFirstOfWhatOccursTwice) {
  const Database database = parse(R"(BO_ 1 A: 8 X
 SG_ S : 0|8@1+ (1,0) [0|0] "" X
 SG_ S : 8|8@1+ (1,0) [0|0] "" X
BO_ 1 B: 8 X
 SG_ T : 0|8@1+ (1,0) [0|0] "" X
BO_ 2 A: 4 X
)");
  ASSERT_EQ(database.messages.size(), 2U);
  EXPECT_EQ(database.messages[0].signals.size(), 1U);
  EXPECT_EQ(database.messages[0].signals[0].start_bit, 0);
  EXPECT_EQ(find_message(database, "A")->id, 1U);
  EXPECT_THAT(warnings_of(database), ElementsAre(HasSubstr("car.dbc:3: message 'A' has two"),
                                                 HasSubstr("car.dbc:4: message 'B' has the id"),
                                                 HasSubstr("car.dbc:6: message 'A' has the name")));
}

TEST(Dbc, LeavesOutWhatIsNoFrame) {
  const Database database = parse(R"(BO_ 3221225472 VECTOR__INDEPENDENT_SIG_MSG: 0 X
 SG_ Spare : 0|8@1+ (1,0) [0|0] "" X
BO_ 2147483650 Transport: 1785 X
 SG_ Far : 0|8@1+ (1,0) [0|0] "" X
BO_ 5 Real: 1 X
CM_ BO_ 3221225472 "not used";
CM_ SG_ 2147483650 Far "left out with its message";
)");
  ASSERT_EQ(database.messages.size(), 1U);
  EXPECT_EQ(database.messages[0].name, "Real");
  EXPECT_THAT(warnings_of(database),
              ElementsAre(HasSubstr("car.dbc:3: message 'Transport' has 1785 bytes")));
}

TEST(Dbc, PassesOverOtherStatements) {
  const Database database = parse(R"(VERSION "HIPBNYYYYYYYYYYYYYYYY"
NS_ : CM_ BA_
 BA_DEF_REL_
BS_: 500 : 1,2
BU_:
 FRONT
 REAR
VAL_TABLE_ OnOff 1 "On" 0 "Off" ;
BO_ 1 A: 8 FRONT
 SG_ S : 0|8@1+ (1,0) [0|0] "" REAR FRONT
BO_TX_BU_ 1 : FRONT,REAR;
EV_ Temperature: 0 [0|0] "" 0 7 DUMMY_NODE_VECTOR0 Vector__XXX;
ENVVAR_DATA_ Data: 5;
CM_ BU_ FRONT "a node";
CM_ EV_ Temperature "a variable";
BA_DEF_ SG_ "GenSigStartValue" FLOAT 0 1;
BA_DEF_REL_ BU_SG_REL_ "GenSigTimeoutTime" INT 0 65535;
BA_DEF_DEF_ "GenSigStartValue" 0;
BA_ "GenSigStartValue" SG_ 1 S 3.5;
BA_ "BusType" "CAN";
BA_REL_ "GenSigTimeoutTime" BU_SG_REL_ REAR SG_ 1 S 50;
VAL_ Temperature 0 "cold" 1 "warm" ;
SIG_GROUP_ 1 Group 1 : S;
SGTYPE_ Kind : 8 @1+ (1,0) [0|0] "" 0, OnOff;
FUTURE_THING_ 1 2 "three";
)");
  EXPECT_THAT(warnings_of(database), IsEmpty());
  ASSERT_EQ(database.messages.size(), 1U);
  EXPECT_EQ(database.messages[0].signals.size(), 1U);
}

TEST(Dbc, TakesEveryLineEndAndCharacterSet) {
  const std::string latin =
      "\xEF\xBB\xBF"
      "BO_ 1 A: 8 X\r\n SG_ S : 0|8@1+ (1,0) [0|0] \"\xB0/s\" X\r\nCM_ SG_ 1 S \"m\xFC\x80\";\r\n";
  const Database database = parse(latin);
  EXPECT_THAT(warnings_of(database), IsEmpty());
  EXPECT_EQ(database.messages[0].signals[0].unit, "\u00B0/s");
  EXPECT_EQ(database.messages[0].signals[0].comment, "m\u00FC\u20AC");
  EXPECT_EQ(
      parse("BO_ 1 A: 8 X\n SG_ S : 0|8@1+ (1,0) [0|0] \"°\" X\n").messages[0].signals[0].unit,
      "°");
}

TEST(DbcErrors, RefuseALastLineThatIsCutInsideANameOrAUnit) {
  const std::string whole =
      "BU_: Engine Vector__XXX\nBO_ 1 A: 8 Engine\n SG_ S : 0|8@1+ (1,0) [0|0] \"m/s\" Vector__XXX";
  EXPECT_EQ(parse(whole).messages.size(), 1U);
  for (const std::string_view end : {"__XXX", "or__XXX", " Vector__XXX"}) {
    const std::string cut = whole.substr(0, whole.size() - end.size());
    EXPECT_THROW((void)parse(cut), DbcError) << cut;
  }
}

TEST(Dbc, SuspectsACutAtTheEnd) {
  EXPECT_THAT(warnings_of(parse("BO_ 1 A: 8 X\n SG_ S : 0|8@1+ (1,0) [0|0] \"\" X")),
              ElementsAre(HasSubstr("car.dbc:2: the file does not end with a line end")));
  EXPECT_THAT(warnings_of(parse("BO_ 1 A: 8 X\nVAL_ 1 S 0 \"a\"\n")),
              ElementsAre(HasSubstr("found end of file"), HasSubstr("names signal 'S'")));
}

TEST(Dbc, ReadsOurOwnBus) {
  const Database database = read_dbc(ODOMD_SOURCE_DIR "/can_protocol/odomd.dbc");
  EXPECT_THAT(warnings_of(database), IsEmpty());
  ASSERT_EQ(database.messages.size(), 4U);
  for (const Message& message : database.messages) {
    EXPECT_NE(find_signal(message, message.name + "_CRC"), nullptr);
    EXPECT_NE(find_signal(message, message.name + "_Counter"), nullptr);
    EXPECT_GE(message.cycle_time_ns, 5'000'000);
    EXPECT_LE(message.cycle_time_ns, 10'000'000);
    for (const Signal& signal : message.signals)
      EXPECT_FALSE(signal.comment.empty() && signal.unit.empty());
  }
}

// Errors: file, line, what was expected and what was found ----------------------------------------

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
BO_ 1 A: 8 X¶ SG_ S : 0|8@1+ (1,0) [0| -> 2: expected the signal's maximum, found end of file
BO_ 1 A: 8 X¶CM_ BO_ 1 "abc¶def -> 2: expected '"' that closes the text begun here
BO_ 1 A: 8 X¶VAL_ 1 S 0 "a" 1 -> 2: expected the value's name in quotes, found end of
BO_ 1 A: 8 X¶VAL_ 1 S 0 "a" -> 2: expected ';' at the end of VAL_, found end of file
BO_ 1 A: 8 X¶BO_TX_BU_ 1 : A, -> 2: expected ';' at the end of BO_TX_BU_, found end of file
BO_ 1 A: 8 X¶ SG_ S : 0|0@1+ (1,0) [0|0] "" X¶ -> 2: expected the length of signal 'S', 1 to 64 bits, found 0
BO_ 1 A: 8 X¶ SG_ S : 0|65@1+ (1,0) [0|0] "" X¶ -> 2: expected the signal's length in bits, 1 to 64, found '65'
BO_ 1 A: 8 X¶ SG_ S : 505|8@1+ (1,0) [0|0] "" X¶ -> 2: expected a start bit from which signal 'S' fits 64 bytes,
  found '505'
BO_ 1 A: 8 X¶ SG_ S : 504|2@0+ (1,0) [0|0] "" X¶ -> 2: expected a start bit from which signal 'S' fits 64 bytes,
  found '504'
BO_ 1 A: 8 X¶ SG_ S : 0|8@2+ (1,0) [0|0] "" X¶ -> 2: expected byte order and sign, one of 1+ 1- 0+ 0-, found '2+'
BO_ 1 A: 8 X¶ SG_ S : 0|8@1+ (0,1,0) [0|0] "" X¶ -> 2: expected ')' after the offset, found ','
BO_ 1 A: 8 X¶ SG_ S : 0|8@1+ (nan,0) [0|0] "" X¶ -> 2: expected the signal's factor, found 'nan'
BO_ 1 A: 8 X¶ SG_ S : 0|8@1+ (1,1e999) [0|0] "" X¶ -> 2: expected the signal's offset, found '1e999'
BO_ 1 A: 8 X¶ SG_ S : 0|8@1+ (1,0) [0|0] rad X¶ -> 2: expected the signal's unit in quotes, found 'rad'
BO_ 1 A: 8 X¶ SG_ S : 0|8@1+ (1,0) [0|0] "rad X¶ -> 2: expected '"' that closes the text begun here, found end of
  file
BO_ 1 A: 8 X¶ SG_ S : 0|8@1+ (1,0) [0|0] "rad X¶ SG_ T : 0|8@1+ (1,0) [0|0] "m" X¶ -> 2: expected '"' that closes
  the text begun here, found another statement
BO_ 1 A: 8 X¶VAL_ 1 S 0 "a 1 "b" ;¶CM_ BO_ 1 "text";¶ -> 2: expected a raw value, found 'b'
BO_ 1 A: 8 X¶VAL_ 1 S 0 "a ;¶CM_ BO_ 1 "text";¶ -> 2: expected '"' that closes the text begun here, found another
  statement
BO_ 1 A: 8 X¶ SG_ S mX : 0|8@1+ (1,0) [0|0] "" X¶ -> 2: expected ':' or a multiplexing (M, m0, m0M) after the
  signal's name, found 'mX'
BO_ 1 A: 8 X¶ SG_ S : 0|16@1+ (1,0) [0|0] "" X¶¶SIG_VALTYPE_ 1 S : 1;¶ -> 4: expected 32 bits for the floating-point
  signal 'S', found 16
BO_ 1 A: 8 X¶ SG_ S : 0|16@1+ (1,0) [0|0] "" X¶SIG_VALTYPE_ 1 S : 3;¶ -> 3: expected 0 (integer), 1 (float) or 2
  (double), found '3'
BO_ 1 A: 8 X¶ SG_ S : 0|16@1+ (1,0) [0|0] "" X¶SG_MUL_VAL_ 1 S M 3-1;¶ -> 3: expected a range of multiplexor values,
  found '3-1'
BO_ 1 A: 8 X¶ SG_ S m0 : 0|16@1+ (1,0) [0|0] "" X¶SG_MUL_VAL_ 1 S M 1-1;¶ -> 3: expected the one multiplexor of
  signal 'S', found 'M'
BO_ 1 A: 8 X¶ SG_ S m0M : 0|4@1+ (1,0) [0|0] "" X¶ SG_ T m0M : 4|4@1+ (1,0) [0|0] "" X¶SG_MUL_VAL_ 1 S T
  1-1;¶SG_MUL_VAL_ 1 T S 1-1;¶ -> 2: expected a multiplexor above signal 'S', found a cycle
BO_ 1 A: 8 X¶ SG_ S M : 0|4@1+ (1,0) [0|0] "" X¶ SG_ T M : 4|4@1+ (1,0) [0|0] "" X¶ SG_ U m1 : 8|4@1+ (1,0) [0|0] ""
  X¶ -> 4: expected one multiplexor for signal 'U', found 2 in message 'A'
BO_ 1 A: 8 X¶BA_ "GenMsgCycleTime" BO_ 1 "fast";¶ -> 2: expected the cycle time in milliseconds, found "fast"
BO_ 1 A: 8 X¶CM_ SG_ 1 S text;¶ -> 2: expected the comment in quotes, found 'text'
)",
               expect_complaint);
  expect_complaint("BO_ 1 A: 8 X\n\x01\x02", "2: expected text, found byte 1");
  expect_complaint("BO_ 1 A 8 X\n\x01", "1: expected ':' after the message's name");
  expect_complaint(
      nested(18),
      "19: expected at most 16 multiplexors one above the other, found more above signal 'S17'");
  expect_complaint("BO_ 1 " + std::string(256, 'A') + ": 8 X\n",
                   "1: expected a name of at most 255 bytes, found 256: 'AAAA");
}

// Hostile databases: the number of warnings and the effort are bounded by the size of the file.

TEST(Dbc, TakesSixteenMultiplexorsOneAboveTheOther) {
  EXPECT_EQ(parse(nested(17)).messages[0].signals.size(), 17U);
}

std::string many_signals(int count, const std::string& multiplexing_of_first) {
  std::string text =
      "BO_ 1 A: 64 X\n SG_ R " + multiplexing_of_first + ": 0|16@1+ (1,0) [0|0] \"\" X\n";
  for (int i = 0; i < count; ++i)
    text += " SG_ S" + std::to_string(i) +
            (multiplexing_of_first.empty() ? "" : " m" + std::to_string(i)) +
            " : 16|8@1+ (1,0) [0|0] \"\" X\n";
  return text;
}

TEST(Dbc, WarnsOnceOfASignalThatLiesOnManyOthers) {
  const auto warnings = warnings_of(parse(many_signals(300, "")));
  EXPECT_EQ(warnings.size(), 299U);
  EXPECT_EQ(warnings.front(), "car.dbc:4: signals 'S0' and 'S1' of message 'A' overlap");
  EXPECT_EQ(warnings.back(),
            "car.dbc:302: signal 'S299' of message 'A' overlaps 'S0' and 298 more");
}

TEST(Dbc, SaysSoWhereTooManySignalsWouldHaveToBeCompared) {
  EXPECT_THAT(warnings_of(parse(many_signals(1000, "M "))), IsEmpty());
  EXPECT_THAT(warnings_of(parse(many_signals(20000, "M "))),
              ElementsAre("car.dbc:1: too many signals to compare them all; some may overlap "
                          "without a warning"));
}

TEST(Dbc, WarnsOnceOfAMessageWhoseNameManyOthersHave) {
  std::string text;
  for (int i = 0; i < 300; ++i) text += "BO_ " + std::to_string(i) + " A: 8 X\n";
  EXPECT_EQ(parse(text).warnings.size(), 299U);
}

TEST(DbcErrors, RefuseADevice) {
  EXPECT_EQ(message_of([] { (void)read_dbc("/dev/zero"); }), "/dev/zero: is a device; name a file");
}

TEST(DbcErrors, SayThatAFileCannotBeRead) {
  EXPECT_THROW((void)read_dbc("/nonexistent/car.dbc"), DbcError);
  EXPECT_THROW((void)read_dbc("/"), DbcError);
  EXPECT_THROW((void)read_dbc("/dev/null"), DbcError);
}

TEST(DbcErrors, NeverCrashOnACutFile) {
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
}  // namespace odomd::can::dbc_test
