// An unusable part of a database does not affect other parts: twenty siblings of each kind, before,
// between and after usable messages.
#include <fmt/format.h>

#include "can_protocol/dbc/dbc.hpp"
#include "tests/can_protocol/decode/one_binding.hpp"
#include "tests/gtest.hpp"

namespace odomd::can::left_out_test {
namespace {

constexpr int siblings = 20;

/// In sibling n, every # becomes `first` + n * `step`, and every $ a double-byte character.
struct Kind {
  const char* name;
  int first;
  int step;
  std::string signals;     ///< signals of message 2
  std::string statements;  ///< after all messages
  std::size_t warnings = 1;
  std::string_view left_out = "Odd";  ///< the signal that is left out; "": none
};

std::string signal(std::string_view name, std::string_view bits,
                   std::string_view scaling = R"((1,0) [0|0] "")") {
  return fmt::format(" SG_ {} : {}@1+ {} X\n", name, bits, scaling);
}

const std::string plain = signal("Odd", "0|16");
const std::string multiplexed = signal("A M", "0|4") + signal("Odd m#", "8|8");

const std::vector<Kind> kinds{
    {"Length", 65, 27, signal("Odd", "0|#"), ""},
    {"BeyondItsMessage", 57, 20, signal("Odd", "#|8"), ""},
    {"BeyondAnyFrame", 505, 31, signal("Odd", "#|8"), ""},
    {"Factor", 309, 1, signal("Odd", "0|8", R"((1e#,0) [0|0] "")"), ""},
    {"Offset", 309, 77, signal("Odd", "0|8", R"((1,-2.5e#) [0|0] "")"), ""},
    {"DecimalComma", 1, 1, signal("Odd", "0|8", R"((0,#,0) [0|0] "")"), ""},
    {"Float", 12, 1, signal("Odd", "0|#"), "SIG_VALTYPE_ 2 Odd : 1;\n"},
    {"Double", 32, 1, signal("Odd", "0|#"), "SIG_VALTYPE_ 2 Odd : 2;\n"},
    {"FloatType", 3, 1, plain, "SIG_VALTYPE_ 2 Odd : #;\n"},
    {"TwoMultiplexors", 0, 1, multiplexed + signal("B M", "4|4"), ""},
    {"AbsentMultiplexor", 0, 1, multiplexed, "SG_MUL_VAL_ 2 Odd B# 0-#;\n"},
    {"MultiplexorValue", 0, 3, multiplexed, "SG_MUL_VAL_ 2 Odd A 99-#;\n"},
    {"LongMultiplexor", 65, 1, signal("A M", "0|#") + signal("Odd m1", "8|8"), "", 2},
    {"Range", 309, 1, signal("Odd", "0|8", R"((1,0) [-1e#|1e#] "")"), "", 1, ""},
    {"RangeOfTexts", 0, 1, signal("Odd", "0|8", R"((1,0) [-1.#INF|nan#] "")"), "", 1, ""},
    {"RangeBelowAnyDouble", 0, 1, signal("Odd", "0|8", R"((1,0) [0|1.797693134862#E+309] "")"), "",
     1, ""},
    {"UnitOnTwoLines", 0, 1, signal("Odd", "0|8", "(1,0) [0|0] \"m\n #/s\""), "", 1, ""},
    {"TextOnTwoLines", 1, 1, plain, "VAL_ 2 Odd 0 \"off\" # \"not\nvalid\" 99 \"on\" ;\n", 1, ""},
    {"UnknownTable", 0, 1, plain, "VAL_ 2 Odd Table# ;\n", 1, ""},
    {"OpenText", 0, 1, plain, "VAL_ 2 Odd # \"open ;\nVERSION \"1\"\n", 1, ""},
    {"Garbage", 0, 1, plain, "# <damaged>\n", 1, ""},
    {"BlockComment", 0, 1, "/*\n BO_ # \" /* */" + plain, "/* #\n * VAL_ */ // */\n", 0, ""},
    {"DoubleByteText", 0, 1, plain,
     "VAL_ 2 Odd 0 \"$\" 1 \"$$\"\n 2 \"\xA1$\" ;\nCM_ SG_ 2 Odd \"$\" ;\n"
     "CM_ BO_ 2 \"a \\\"$\";\nBA_DEF_ \"E\" ENUM \"$\",\"$\";\n",
     0, ""},
    {"DoubleByteUnit", 0, 1, signal("Odd", "0|8", "(1,0) [0|0] \"$\""), "", 0, ""},
};

/// Replaces $ with characters whose second byte is a backslash, in Shift-JIS, GBK or Big5.
std::string sibling(const Kind& kind, int n, std::string text) {
  constexpr std::string_view leads = "\x83\x95\x94\x8A\x90\xE3\xFA\xA5\xB3\xBB";
  const std::string character{leads[static_cast<std::size_t>(n) % leads.size()], '\\'};
  for (const auto& [mark, by] :
       {std::pair{'#', std::to_string(kind.first + n * kind.step)}, std::pair{'$', character}})
    for (std::size_t at = text.find(mark); at != std::string::npos; at = text.find(mark, at + 1))
      text.replace(at, 1, by);
  return text;
}

std::string message(int id, const std::string& signals) {
  return fmt::format("BO_ {} M{}: 8 X\n", id, id) + signals + signal("Kept", "40|8");
}

TEST(DbcLeftOut, AffectsNothingElseAndIsReportedIfMapped) {
  for (const Kind& kind : kinds)
    for (int n = 0; n < siblings; ++n) {
      SCOPED_TRACE(fmt::format("{} {}", kind.name, n));
      std::vector<std::string> messages{message(1, ""), message(3, "")};
      messages.insert(messages.begin() + n % 3, message(2, sibling(kind, n, kind.signals)));
      const std::string text = fmt::format(
          "VERSION \"\"\n{}\n{}{}VAL_ 3 Kept 7 \"seven\" ;\n", fmt::join(messages, "\n"),
          sibling(kind, n, kind.statements), "CM_ BO_ 1 \"first\";\n");
      const Database database = parse_dbc(text, "car.dbc");
      ASSERT_EQ(database.messages.size(), 3U) << text;
      EXPECT_EQ(database.warnings.size(), kind.warnings) << text;
      EXPECT_EQ(find_message(database, "M1")->comment, "first");
      EXPECT_EQ(find_message(database, "M3")->signals.at(0).values.size(), 1U);
      for (const Message& other : database.messages) {
        const Signal* kept = find_signal(other, "Kept");
        ASSERT_NE(kept, nullptr) << other.name;
        EXPECT_EQ(kept->start_bit, 40U);
      }
      const bool usable = kind.left_out.empty();
      EXPECT_EQ(find_signal(*find_message(database, "M2"), "Odd") != nullptr, usable);
      const std::string refused = refusal(database, {binding_of("M2", "Odd")});
      if (usable)
        EXPECT_EQ(refused, "");
      else
        EXPECT_THAT(refused, HasSubstr("no signal 'Odd'; it was left out in line "));
      EXPECT_EQ(refusal(database, {binding_of("M3", "Kept")}), "");
    }
}

TEST(DbcLeftOut, MessageHasItsReason) {
  const std::vector<std::string> heads{"BO_ 2 M2 8 X\n", "BO_ 2 M2: 8000000 X\n",
                                       "BO_ 2 M2: 100 X\n", "BO_ 3758096384 M2: 8 X\n",
                                       "BO_ 1 M2: 8 X\n"};
  for (const std::string& head : heads) {
    SCOPED_TRACE(head);
    const Database database = parse_dbc(
        message(1, "") + head + signal("A", "600|8") + signal("Kept", "0|8") + message(3, ""),
        "car.dbc");
    EXPECT_EQ(database.messages.size(), 2U);
    EXPECT_EQ(database.warnings.size(), 1U);
    EXPECT_THAT(refusal(database, {binding_of("M2", "Kept")}),
                HasSubstr("no message 'M2' in car.dbc; it was left out in line 3: "));
    EXPECT_EQ(find_message(database, "M1")->signals.size(), 1U);
  }
  // The signals after an unreadable line are not added to the message before it.
  const Database database =
      parse_dbc(message(1, "") + "B0_ 2 M2: 8 X\n" + signal("Other", "0|8"), "car.dbc");
  ASSERT_EQ(database.messages.size(), 1U);
  EXPECT_EQ(database.messages[0].signals.size(), 1U);
}

TEST(DbcLeftOut, ListsTwentyThenCounts) {
  std::string text;
  for (int id = 1; id <= 50; ++id) text += message(id, signal("Vin", "0|136"));
  const Database database = parse_dbc(text, "car.dbc");
  EXPECT_EQ(database.messages.size(), 50U);
  ASSERT_EQ(database.warnings.size(), 21U);
  EXPECT_THAT(database.warnings.back().text, HasSubstr("30 more"));
  EXPECT_THAT(refusal(database, {binding_of("M50", "Vin")}), HasSubstr("found '136'"));
}

TEST(DbcValueTables, AreFoundByName) {
  const Database database = parse_dbc(
      "VAL_TABLE_ OnOff 1 \"On\" 0 \"Off\" ;\n" + message(1, "") + "VAL_ 1 Kept OnOff ;\n",
      "car.dbc");
  ASSERT_EQ(database.messages.at(0).signals.at(0).values.size(), 2U);
  EXPECT_EQ(database.messages[0].signals[0].values[0].name, "On");
  EXPECT_EQ(database.warnings.size(), 1U);
}

TEST(DbcTexts, KeepEscapedQuotesInEveryEncoding) {
  for (const std::string_view letter : {"o", "\xF6", "\xC3\xB6"}) {  // ASCII, Latin-1, UTF-8
    SCOPED_TRACE(letter);
    const Database database = parse_dbc(
        message(1, "") + fmt::format("CM_ BO_ 1 \"{0} \\\"{0}\\\" {0}\\\"{0}\\\" {0}\";\n", letter),
        "car.dbc");
    EXPECT_EQ(database.warnings.size(), 0U);
    const std::string& comment = database.messages.at(0).comment;
    EXPECT_EQ(std::count(comment.begin(), comment.end(), '"'), 4) << comment;
  }
}

}  // namespace
}  // namespace odomd::can::left_out_test
