// The DBC reader: what it accepts, accepts with a warning, or ignores.
#include "can_protocol/dbc/dbc.hpp"

#include "tests/can_protocol/dbc/parsed.hpp"
#include "tests/gtest.hpp"

namespace odomd::can::dbc_test {
namespace {

void expect_listing(std::string_view text, std::string_view expected) {
  const Database database = parse(text);
  EXPECT_THAT(warnings_of(database), IsEmpty());
  EXPECT_EQ(listing(database), expected);
}

TEST(Dbc, ReadsMessagesAndSignals) {
  expect_listing(R"(VERSION ""
NS_ :
	CM_
	BA_DEF_
BS_:
BU_: ECU OTHER
BO_ 288 Imu: 6 ECU
 SG_ YawRate : 0|16@1- (0.0005,-1.5) [-16|16] "rad/s" OTHER,ECU
 SG_ AccX : 23|12@0+ (1E-2,0) [0|0] "m/s2" Vector__XXX

BO_ 2147484000 Long: 64 Vector__XXX
)",
                 R"(7: Imu 288 6 ECU
 8: YawRate 0|16 <- (0.0005,-1.5) [-16|16] "rad/s"
 9: AccX 23|12 >+ (0.01,0) [0|0] "m/s2"
11: Long 352 64 Vector__XXX x fd
)");
}

TEST(Dbc, ReadsFloatsNamesCommentsAndCycleTimes) {
  expect_listing(R"(BO_ 1 A: 8 X
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
)",
                 R"(1: A 1 8 X 20000 us # first
and "second" line
 2: F 0|32 <f (1,0) [0|0]
 3: I 32|8 <+ (1,0) [0|0] # an integer 0=off 1=on -1=never
4: B 2 8 X fd 2500 us
 5: D 7|64 >d (1,0) [0|0]
6: C 3 8 X 100000 us
)");
}

// Multiplexing: simple, nested (extended statements), and with marks that have no number.
TEST(Dbc, ReadsMultiplexing) {
  expect_listing(R"(BO_ 1 A: 8 X
 SG_ Two m2 : 8|8@1+ (1,0) [0|0] "" X
 SG_ Page M : 0|8@1+ (1,0) [0|0] "" X
BO_ 2 B: 8 X
 SG_ Root M : 0|4@1+ (1,0) [0|0] "" X
 SG_ Inner m1M : 8|8@1+ (1,0) [0|0] "" X
 SG_ Simple m0 : 8|16@1+ (1,0) [0|0] "" X
 SG_ Deep m3 : 16|16@1+ (1,0) [0|0] "" X
 SG_ Always : 4|4@1+ (1,0) [0|0] "" X
SG_MUL_VAL_ 2 Simple Root 0-0, 4-6;
SG_MUL_VAL_ 2 Inner Root 1-1;
SG_MUL_VAL_ 2 Deep Inner 3-3,7-9;
BO_ 3 C: 8 X
 SG_ Page M : 0|8@1+ (1,0) [0|0] "" X
 SG_ Sub mM : 8|8@1+ (1,0) [0|0] "" X
 SG_ Deep m : 16|8@1+ (1,0) [0|0] "" X
SG_MUL_VAL_ 3 Sub Page 2-3;
SG_MUL_VAL_ 3 Deep Sub 5-5;
)",
                 R"(1: A 1 8 X
 2: Two 8|8 <+ (1,0) [0|0] m1 2-2
 3: Page 0|8 <+ (1,0) [0|0] M
4: B 2 8 X
 5: Root 0|4 <+ (1,0) [0|0] M
 6: Inner 8|8 <+ (1,0) [0|0] M m0 1-1
 7: Simple 8|16 <+ (1,0) [0|0] m0 0-0 4-6
 8: Deep 16|16 <+ (1,0) [0|0] m1 3-3 7-9
 9: Always 4|4 <+ (1,0) [0|0]
13: C 3 8 X
 14: Page 0|8 <+ (1,0) [0|0] M
 15: Sub 8|8 <+ (1,0) [0|0] M m0 2-3
 16: Deep 16|8 <+ (1,0) [0|0] m1 5-5
)");
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
  EXPECT_EQ(listing(database), R"(3: 4WD 2048 2 X x # text without signal
 4: 2ND_GEAR 0|8 <+ (0.25,-0.5) [0|0] 0=two lines
 5: Low 4|8 <+ (1,0) [0|0] 0=off 1=on
)");
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

TEST(Dbc, WarnsAboutASignalThatNoMultiplexorValueSelects) {
  const Database database = parse(R"(BO_ 2147483649 A: 8 X
 SG_ Page M : 0|4@1+ (1,0) [0|0] "" X
 SG_ Low m15 : 8|8@1+ (1,0) [0|0] "" X
 SG_ High m16 : 8|8@1+ (1,0) [0|0] "" X
 SG_ Lost m : 8|8@1+ (1,0) [0|0] "" X
BO_ 2 B: 8 X
 SG_ Alone m : 8|8@1+ (1,0) [0|0] "" X
CM_ BO_ 2147483650 "another";
)");
  EXPECT_THAT(
      warnings_of(database),
      ElementsAre(
          HasSubstr("car.dbc:4: signal 'High' is never present: multiplexor 'Page'"),
          AllOf(StartsWith("car.dbc:5: signal 'Lost' is never present"), HasSubstr("'Page'")),
          AllOf(StartsWith("car.dbc:7: signal 'Alone' is multiplexed"),
                HasSubstr("always present")),
          HasSubstr("car.dbc:8: CM_ BO_ names message 2147483650,")));
  EXPECT_EQ(listing(database), R"(1: A 1 8 X x
 2: Page 0|4 <+ (1,0) [0|0] M
 3: Low 8|8 <+ (1,0) [0|0] m0 15-15
 4: High 8|8 <+ (1,0) [0|0] m0 16-16
 5: Lost 8|8 <+ (1,0) [0|0] m0
6: B 2 8 X
 7: Alone 8|8 <+ (1,0) [0|0]
)");
}

TEST(Dbc, UsesTheFirstOfDuplicates) {
  const Database database = parse(R"(BO_ 1 A: 8 X
 SG_ S : 0|8@1+ (1,0) [0|0] "" X
 SG_ S : 8|8@1+ (1,0) [0|0] "" X
BO_ 1 B: 8 X
 SG_ T : 0|8@1+ (1,0) [0|0] "" X
BO_ 2 A: 4 X
)");
  EXPECT_EQ(listing(database), R"(1: A 1 8 X
 2: S 0|8 <+ (1,0) [0|0]
6: A 2 4 X
)");
  EXPECT_EQ(find_message(database, "A")->id, 1U);
  EXPECT_EQ(find_message(database, "B"), nullptr);
  EXPECT_THAT(warnings_of(database), ElementsAre(HasSubstr("car.dbc:3: message 'A' has two"),
                                                 HasSubstr("car.dbc:4: message 'B' has the id"),
                                                 HasSubstr("car.dbc:6: message 'A' has the name")));
}

TEST(Dbc, LeavesOutImpossibleIdentifiersAndLengths) {
  const Database database = parse(R"(BO_ 536870912 Wide: 8 X
 SG_ S : 0|8@1+ (1,0) [0|0] "" X
BO_ 3758096384 WideExtended: 8 X
BO_ 4294967296 Wider: 8 X
BO_ 99999999999999999999 Widest: 8 X
BO_ -1 Negative: 8 X
BO_ 2684354559 Largest: 1 X
BO_ 3221225472 VECTOR__INDEPENDENT_SIG_MSG: 0 X
 SG_ Spare : 0|8@1+ (1,0) [0|0] "" X
BO_ 2147483650 Transport: 1785 X
CM_ BO_ 536870912 "left out with its message";
CM_ SG_ 536870912 S "likewise";
CM_ BO_ 3221225472 "not used";
BA_ "GenMsgCycleTime" BO_ 99999999999999999999 10;
BA_ "GenMsgCycleTime" BO_ 536870913 10;
)");
  EXPECT_EQ(listing(database), "7: Largest 536870911 1 X x\n");
  EXPECT_THAT(
      warnings_of(database),
      ElementsAre(AllOf(StartsWith("car.dbc:1: "), HasSubstr(" 536870912 "), HasSubstr("'Wide'")),
                  AllOf(StartsWith("car.dbc:3: "), HasSubstr(" 3758096384 ")),
                  AllOf(StartsWith("car.dbc:4: "), HasSubstr(" 4294967296 ")),
                  AllOf(StartsWith("car.dbc:5: "), HasSubstr(" 99999999999999999999 ")),
                  AllOf(StartsWith("car.dbc:6: "), HasSubstr(" -1 ")),
                  HasSubstr("car.dbc:10: message 'Transport' has 1785 bytes"),
                  AllOf(StartsWith("car.dbc:15: "), HasSubstr("message 536870913, which is not"))));
}

TEST(Dbc, SkipsOtherStatements) {
  expect_listing(R"(VERSION "HIPBNYYYYYYYYYYYYYYYY"
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
)",
                 "9: A 1 8 FRONT\n 10: S 0|8 <+ (1,0) [0|0]\n");
}

TEST(Dbc, SkipsLineComments) {
  expect_listing(R"(// a car's "first" database
VERSION ""// 2
NS_ : // none
BU_: ECU // BO_ 7 Not: 8 X
BO_ 1 A: 8 ECU//the message
// SG_ Gone : 0|8@1+ (1,0) [0|0] "" ECU
 SG_ S : 0|8@1+ (1,0) [0|0] "m//s" ECU // up to here
CM_ SG_ 1 S "see // there"; // "not this
VAL_ 1 S 0 "a" // one
 1 "b" ;
BO_ 2 B: 8 ECU
// the end)",
                 R"(5: A 1 8 ECU
 7: S 0|8 <+ (1,0) [0|0] "m//s" # see // there 0=a 1=b
11: B 2 8 ECU
)");
  for (const std::string_view end : {"  ", "VAL_ 1 S 0 \"a\"; // the end"})
    EXPECT_THAT(
        warnings_of(parse("BO_ 1 A: 8 X\n SG_ S : 0|8@1+ (1,0) [0|0] \"\" Y\n" + std::string(end))),
        IsEmpty())
        << end;
  EXPECT_THAT(warnings_of(parse("BO_ 1 A: 8 X / no\n")), ElementsAre(HasSubstr("found '/'")));
}

TEST(Dbc, AcceptsEveryLineEndAndCharacterSet) {
  expect_listing(
      "\xEF\xBB\xBF"
      "BO_ 1 A: 8 X\r\n SG_ S : 0|8@1+ (1,0) [0|0] \"\xB0/s\" X\r\nCM_ SG_ 1 S \"m\xFC\x80\";\r\n",
      "1: A 1 8 X\n 2: S 0|8 <+ (1,0) [0|0] \"\u00B0/s\" # m\u00FC\u20AC\n");
  expect_listing("BO_ 1 A: 8 X\n SG_ S : 0|8@1+ (1,0) [0|0] \"°\" X\n",
                 "1: A 1 8 X\n 2: S 0|8 <+ (1,0) [0|0] \"°\"\n");
}

TEST(Dbc, FindsLongNamesByTheirShortNamesToo) {
  const Database database = parse(R"(BU_: GATEWAY_0001
BO_ 1 ROTATION_0001: 8 GATEWAY_0001
 SG_ YAW_0001 M : 0|8@1+ (1,0) [0|0] "deg/s" X
 SG_ Plain m : 8|8@1+ (1,0) [0|0] "" X
BA_DEF_ SG_ "SystemSignalLongSymbol" STRING ;
BA_DEF_DEF_ "SystemSignalLongSymbol" "";
BA_ "SystemNodeLongSymbol" BU_ GATEWAY_0001 "CENTRAL_GATEWAY";
BA_ "SystemMessageLongSymbol" BO_ 1 "ROTATION_OF_THE_BODY";
BA_ "SystemSignalLongSymbol" SG_ 1 YAW_0001 "YAW_RATE";
BA_ "SystemSignalLongSymbol" SG_ 1 Plain "";
SG_MUL_VAL_ 1 Plain YAW_0001 3-3;
CM_ SG_ 1 YAW_0001 "to the left";
)");
  EXPECT_THAT(warnings_of(database), IsEmpty());
  EXPECT_EQ(listing(database), R"(2: ROTATION_OF_THE_BODY 1 8 CENTRAL_GATEWAY short ROTATION_0001
 3: YAW_RATE 0|8 <+ (1,0) [0|0] "deg/s" short YAW_0001 # to the left M
 4: Plain 8|8 <+ (1,0) [0|0] m0 3-3
)");
  const Message& message = database.messages.at(0);
  for (const char* name : {"ROTATION_OF_THE_BODY", "ROTATION_0001"})
    EXPECT_EQ(find_message(database, name), &message) << name;
  for (const char* name : {"YAW_RATE", "YAW_0001"})
    EXPECT_EQ(find_signal(message, name), message.signals.data()) << name;
  EXPECT_EQ(find_signal(message, "Plain"), &message.signals.at(1));
  EXPECT_EQ(find_signal(message, ""), nullptr);
}

TEST(Dbc, IgnoresALongNameThatIsTaken) {
  const std::string messages = R"(BO_ 1 A: 8 X
 SG_ S : 0|8@1+ (1,0) [0|0] "" X
 SG_ T : 8|8@1+ (1,0) [0|0] "" X
BO_ 2 B: 8 X
)";
  const Database database = parse(messages + R"(BA_ "SystemMessageLongSymbol" BO_ 1 "B";
BA_ "SystemSignalLongSymbol" SG_ 1 S "T";
BA_ "SystemSignalLongSymbol" SG_ 1 T "with blanks";
BA_ "SystemSignalLongSymbol" SG_ 1 U "V";
BA_ "SystemMessageLongSymbol" BO_ 3 "C";
BA_ "SystemMessageLongSymbol" BO_ 1 Long;
)");
  EXPECT_THAT(warnings_of(database),
              ElementsAre(AllOf(StartsWith("car.dbc:5: "), HasSubstr("'B'"), HasSubstr("'A'")),
                          AllOf(StartsWith("car.dbc:6: "), HasSubstr("'T'"), HasSubstr("'S'")),
                          AllOf(StartsWith("car.dbc:7: "), HasSubstr("with blanks")),
                          AllOf(StartsWith("car.dbc:8: "), HasSubstr("'U'")),
                          AllOf(StartsWith("car.dbc:9: "), HasSubstr("message 3")),
                          AllOf(StartsWith("car.dbc:10: expected the long name in quotes"),
                                HasSubstr("found 'Long'"))));
  EXPECT_EQ(listing(database), listing(parse(messages)));
}

}  // namespace
}  // namespace odomd::can::dbc_test
