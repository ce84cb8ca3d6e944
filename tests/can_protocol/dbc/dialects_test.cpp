// DBC files of other tools: comments, multiplexing without a number, identifiers that frames cannot
// have, and long names.
#include "can_protocol/dbc/dbc.hpp"
#include "can_protocol/dbc/signal_layout.hpp"
#include "tests/gtest.hpp"

namespace odomd::can::dialects_test {
namespace {

Database parse(std::string_view text) {
  return parse_dbc(text, "car.dbc");
}

std::vector<std::string> warnings_of(const Database& database) {
  std::vector<std::string> texts;
  for (const Warning& warning : database.warnings) texts.push_back(describe(database, warning));
  return texts;
}

// Comments ----------------------------------------------------------------------------------------

TEST(DbcComments, LastToTheEndOfTheirLine) {
  const Database database = parse(R"(// a car's "first" database
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
)");
  EXPECT_THAT(warnings_of(database), IsEmpty());
  ASSERT_EQ(database.messages.size(), 2U);
  ASSERT_EQ(database.messages[0].signals.size(), 1U);
  const Signal& signal = database.messages[0].signals[0];
  EXPECT_EQ(signal.line, 7U);
  EXPECT_EQ(signal.unit, "m//s");
  EXPECT_EQ(signal.comment, "see // there");
  EXPECT_EQ(signal.values.size(), 2U);
  EXPECT_EQ(database.messages[1].line, 11U);
}

TEST(DbcComments, MayEndTheFile) {
  const std::string signal = "BO_ 1 A: 8 X\n SG_ S : 0|8@1+ (1,0) [0|0] \"\" Y\n";
  EXPECT_THAT(warnings_of(parse(signal + "// the end")), IsEmpty());
  EXPECT_THAT(warnings_of(parse(signal + "  ")), IsEmpty());
  EXPECT_THAT(warnings_of(parse(signal + "VAL_ 1 S 0 \"a\"; // the end")), IsEmpty());
}

TEST(DbcComments, AreNoneWithOneSlash) {
  EXPECT_THAT(warnings_of(parse("BO_ 1 A: 8 X / no\n")), ElementsAre(HasSubstr("found '/'")));
}

// Multiplexing without a number -------------------------------------------------------------------

TEST(DbcMultiplexing, HasItsValueFromTheExtendedStatementWhereTheMarkHasNone) {
  const Database database = parse(R"(BO_ 1 A: 8 X
 SG_ Page M : 0|8@1+ (1,0) [0|0] "" X
 SG_ Sub mM : 8|8@1+ (1,0) [0|0] "" X
 SG_ Deep m : 16|8@1+ (1,0) [0|0] "" X
SG_MUL_VAL_ 1 Sub Page 2-3;
SG_MUL_VAL_ 1 Deep Sub 5-5;
)");
  EXPECT_THAT(warnings_of(database), IsEmpty());
  const Message& message = database.messages[0];
  EXPECT_TRUE(message.signals[1].is_multiplexor);
  EXPECT_EQ(message.signals[1].multiplexor, 0U);
  EXPECT_EQ(message.signals[2].multiplexor, 1U);
  EXPECT_TRUE(is_present(message, message.signals[2], std::array<std::uint8_t, 8>{2, 5}));
  EXPECT_FALSE(is_present(message, message.signals[2], std::array<std::uint8_t, 8>{2, 4}));
  EXPECT_FALSE(is_present(message, message.signals[2], std::array<std::uint8_t, 8>{1, 5}));
}

TEST(DbcMultiplexing, NeverSelectsASignalWithoutAnyValue) {
  const Database database = parse(R"(BO_ 1 A: 8 X
 SG_ Page M : 0|8@1+ (1,0) [0|0] "" X
 SG_ Lost m : 8|8@1+ (1,0) [0|0] "" X
 SG_ Zero m0 : 8|8@1+ (1,0) [0|0] "" X
BO_ 2 B: 8 X
 SG_ Alone m : 8|8@1+ (1,0) [0|0] "" X
)");
  EXPECT_THAT(warnings_of(database),
              ElementsAre(AllOf(StartsWith("car.dbc:3: signal 'Lost' is never present"),
                                HasSubstr("'Page'")),
                          AllOf(StartsWith("car.dbc:6: signal 'Alone' is multiplexed"),
                                HasSubstr("always present"))));
  const Message& message = database.messages[0];
  for (unsigned page = 0; page < 256; ++page)
    EXPECT_FALSE(is_present(message, message.signals[1],
                            std::array<std::uint8_t, 8>{static_cast<std::uint8_t>(page)}));
  EXPECT_TRUE(is_present(message, message.signals[2], std::array<std::uint8_t, 8>{}));
}

// Identifiers that no frame has -------------------------------------------------------------------

TEST(DbcIdentifiers, LeaveOutAMessageThatNoFrameHas) {
  const Database database = parse(R"(BO_ 536870912 Wide: 8 X
 SG_ S : 0|8@1+ (1,0) [0|0] "" X
BO_ 3758096384 WideExtended: 8 X
BO_ 4294967296 Wider: 8 X
BO_ 99999999999999999999 Widest: 8 X
BO_ -1 Negative: 8 X
BO_ 2684354559 Largest: 1 X
CM_ BO_ 536870912 "left out with its message";
CM_ SG_ 536870912 S "likewise";
BA_ "GenMsgCycleTime" BO_ 99999999999999999999 10;
BA_ "GenMsgCycleTime" BO_ 536870913 10;
)");
  ASSERT_EQ(database.messages.size(), 1U);
  EXPECT_EQ(database.messages[0].id, 0x1FFF'FFFFU);
  EXPECT_THAT(
      warnings_of(database),
      ElementsAre(AllOf(StartsWith("car.dbc:1: "), HasSubstr(" 536870912 "), HasSubstr("'Wide'")),
                  AllOf(StartsWith("car.dbc:3: "), HasSubstr(" 3758096384 ")),
                  AllOf(StartsWith("car.dbc:4: "), HasSubstr(" 4294967296 ")),
                  AllOf(StartsWith("car.dbc:5: "), HasSubstr(" 99999999999999999999 ")),
                  AllOf(StartsWith("car.dbc:6: "), HasSubstr(" -1 ")),
                  AllOf(StartsWith("car.dbc:11: "), HasSubstr("message 536870913, which is not"))));
}

TEST(DbcIdentifiers, StillMustBeNumbers) {
  for (const std::string_view id : {"0x12", "-", "1.5", "-0x1"})
    EXPECT_THROW((void)parse("BO_ " + std::string(id) + " A: 8 X\n"), DbcError) << id;
}

// Long names --------------------------------------------------------------------------------------

TEST(DbcLongNames, AreTheNamesAndTheShortOnesFindThemToo) {
  const Database database = parse(R"(BU_: CENTRAL_GATEWAY_OF_THE_CHASS0001
BO_ 1 CHASSIS_ROTATION_AND_ACCELER0001: 8 CENTRAL_GATEWAY_OF_THE_CHASS0001
 SG_ YAW_RATE_ABOUT_THE_VERTICAL_0001 M : 0|8@1+ (1,0) [0|0] "deg/s" X
 SG_ Plain m : 8|8@1+ (1,0) [0|0] "" X
BA_DEF_ SG_ "SystemSignalLongSymbol" STRING ;
BA_DEF_DEF_ "SystemSignalLongSymbol" "";
BA_ "SystemNodeLongSymbol" BU_ CENTRAL_GATEWAY_OF_THE_CHASS0001 "CENTRAL_GATEWAY_OF_THE_CHASSIS_BUS";
BA_ "SystemMessageLongSymbol" BO_ 1 "CHASSIS_ROTATION_AND_ACCELERATION_OF_THE_BODY";
BA_ "SystemSignalLongSymbol" SG_ 1 YAW_RATE_ABOUT_THE_VERTICAL_0001 "YAW_RATE_ABOUT_THE_VERTICAL_AXIS_OF_THE_BODY";
BA_ "SystemSignalLongSymbol" SG_ 1 Plain "";
SG_MUL_VAL_ 1 Plain YAW_RATE_ABOUT_THE_VERTICAL_0001 3-3;
CM_ SG_ 1 YAW_RATE_ABOUT_THE_VERTICAL_0001 "to the left";
)");
  EXPECT_THAT(warnings_of(database), IsEmpty());
  const Message& message = database.messages[0];
  EXPECT_EQ(message.name, "CHASSIS_ROTATION_AND_ACCELERATION_OF_THE_BODY");
  EXPECT_EQ(message.short_name, "CHASSIS_ROTATION_AND_ACCELER0001");
  EXPECT_EQ(message.sender, "CENTRAL_GATEWAY_OF_THE_CHASSIS_BUS");
  EXPECT_EQ(find_message(database, message.name), &message);
  EXPECT_EQ(find_message(database, message.short_name), &message);
  const Signal& yaw_rate = message.signals[0];
  EXPECT_EQ(yaw_rate.name, "YAW_RATE_ABOUT_THE_VERTICAL_AXIS_OF_THE_BODY");
  EXPECT_EQ(yaw_rate.comment, "to the left");
  EXPECT_EQ(find_signal(message, yaw_rate.name), &yaw_rate);
  EXPECT_EQ(find_signal(message, "YAW_RATE_ABOUT_THE_VERTICAL_0001"), &yaw_rate);
  EXPECT_EQ(message.signals[1].name, "Plain");
  EXPECT_EQ(message.signals[1].short_name, "");
  EXPECT_EQ(find_signal(message, ""), nullptr);
}

TEST(DbcLongNames, NeverHideAnotherName) {
  const Database database = parse(R"(BO_ 1 A: 8 X
 SG_ S : 0|8@1+ (1,0) [0|0] "" X
 SG_ T : 8|8@1+ (1,0) [0|0] "" X
BO_ 2 B: 8 X
BA_ "SystemMessageLongSymbol" BO_ 1 "B";
BA_ "SystemSignalLongSymbol" SG_ 1 S "T";
BA_ "SystemSignalLongSymbol" SG_ 1 T "with blanks";
BA_ "SystemSignalLongSymbol" SG_ 1 U "V";
BA_ "SystemMessageLongSymbol" BO_ 3 "C";
)");
  EXPECT_THAT(warnings_of(database),
              ElementsAre(AllOf(StartsWith("car.dbc:5: "), HasSubstr("'B'"), HasSubstr("'A'")),
                          AllOf(StartsWith("car.dbc:6: "), HasSubstr("'T'"), HasSubstr("'S'")),
                          AllOf(StartsWith("car.dbc:7: "), HasSubstr("with blanks")),
                          AllOf(StartsWith("car.dbc:8: "), HasSubstr("'U'")),
                          AllOf(StartsWith("car.dbc:9: "), HasSubstr("message 3"))));
  EXPECT_EQ(database.messages[0].name, "A");
  EXPECT_EQ(database.messages[0].signals[0].name, "S");
  EXPECT_EQ(database.messages[0].signals[1].name, "T");
}

TEST(DbcLongNames, MustBeWrittenInQuotes) {
  EXPECT_THAT(warnings_of(parse("BO_ 1 A: 8 X\nBA_ \"SystemMessageLongSymbol\" BO_ 1 Long;\n")),
              ElementsAre(AllOf(StartsWith("car.dbc:2: expected the long name in quotes"),
                                HasSubstr("found 'Long'"))));
}

}  // namespace
}  // namespace odomd::can::dialects_test
