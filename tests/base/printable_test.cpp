// External text in messages.
#include "base/printable.hpp"

#include "tests/gtest.hpp"

namespace odomd::printable_test {
namespace {

TEST(Printable, KeepsTextAsItIs) {
  EXPECT_EQ(escaped("kg·m² – “Gierrate” 角速度 \xF0\x9F\x9A\x97 \\ \""),
            "kg·m² – “Gierrate” 角速度 \xF0\x9F\x9A\x97 \\ \"");
  EXPECT_EQ(escaped(""), "");
}

TEST(Printable, EscapesControlCharacters) {
  EXPECT_EQ(escaped("a\x1b[2J\r\b\x7f"), "a\\u001b[2J\\u000d\\u0008\\u007f");
  EXPECT_EQ(escaped(std::string("\0", 1)), "\\u0000");
  EXPECT_EQ(escaped("one\ntwo\tthree"), "one\\ntwo\\tthree");
  EXPECT_EQ(escaped("one\ntwo\tthree\r", LineBreaks::kept), "one\ntwo\tthree\\u000d");
  EXPECT_EQ(escaped("\xC2\x9B"), "\\u009b");  // C1: CSI in one character
  EXPECT_EQ(escaped("a\xE2\x80\xAE"
                    "b"),
            "a\\u202eb");
}

TEST(Printable, EscapesInvalidUtf8) {
  EXPECT_EQ(escaped("\x9b"
                    "a"),
            "\\x9ba");
  EXPECT_EQ(escaped("\xC3"), "\\xc3");           // cut off
  EXPECT_EQ(escaped("\xC0\x9B"), "\\xc0\\x9b");  // overlong encoding
  EXPECT_EQ(escaped("\xE0\x82\x9B"), "\\xe0\\x82\\x9b");
  EXPECT_EQ(escaped("\xED\xA0\x80"), "\\xed\\xa0\\x80");  // half a surrogate pair
  EXPECT_EQ(escaped("\xF4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");
}

TEST(Printable, ShortensBetweenCharacters) {
  EXPECT_EQ(shortened("abc", 3), "abc");
  EXPECT_EQ(shortened("abcd", 3), "abc…");
  EXPECT_EQ(shortened("ab\xC3\xA4"
                      "d",
                      3),
            "ab…");
  EXPECT_EQ(odomd::quoted("a\nb"), "\"a\\nb\"");
  EXPECT_EQ(odomd::quoted(std::string(100'000, 'x')),
            std::string("\"").append(60, 'x').append("…\""));
}

TEST(Printable, KeepsTheBeginningAndTheEndOfALongMessage) {
  const std::string whole = "odom: \"" + std::string(900, 'x') + "\"; see odom --help";
  EXPECT_EQ(one_line(whole), whole);
  const std::string text = one_line("odom: \"" + std::string(100'000, 'x') + "\"; see odom --help");
  EXPECT_EQ(text.size(), 1000 + std::string("…").size());
  EXPECT_TRUE(text.starts_with("odom: \"xxx"));
  EXPECT_TRUE(text.ends_with("xxx\"; see odom --help"));
  EXPECT_EQ(one_line("a\nb"), "a\\nb");
}

TEST(Utf8, IsRecognisedByItsWholeDefinition) {
  for (const char* text : {"", "a", "\xC3\xB6", "\xE2\x80\xA6", "\xF0\x9F\x9A\x97"})
    EXPECT_TRUE(is_utf8(text)) << escaped(text);
  // Windows-1252, cut off, overlong, a surrogate, beyond Unicode.
  for (const char* text :
       {"\xF6", "a\xC3", "\xC0\x9B", "\xE0\x82\x9B", "\xED\xA0\x80", "\xF4\x90\x80\x80"})
    EXPECT_FALSE(is_utf8(text)) << escaped(text);
  EXPECT_EQ(to_utf8("\xED\xA0\x80"), "\u00ED\u00A0\u20AC");
}

}  // namespace
}  // namespace odomd::printable_test
