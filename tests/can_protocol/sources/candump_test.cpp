// The candump grammar: all forms of a frame, read and written, and the errors of invalid lines.
#include "can_protocol/sources/candump.hpp"

#include <fmt/format.h>

#include "tests/table.hpp"

namespace odomd::can::candump_test {
namespace {

CandumpLine good(std::string_view text) {
  CandumpLine line = parse_candump_line(text);
  EXPECT_TRUE(line.good()) << text << ": expected " << line.expected << " at " << line.column;
  return line;
}

/// "time [ns] interface: s|x (identifier format) identifier kind length bytes", and the flags of
/// FD.
std::string description(const CandumpLine& line) {
  const Frame& frame = line.frame;
  std::string text = fmt::format(
      "{} {}: {}{:X} {} {}", frame.time_ns, line.interface,
      frame.format == IdFormat::extended ? 'x' : 's', frame.id,
      std::array{"data", "remote", "error"}.at(static_cast<std::size_t>(frame.kind)), frame.length);
  if (frame.kind != FrameKind::remote)
    for (const std::uint8_t byte : frame.payload()) text += fmt::format(" {:02X}", byte);
  if (frame.protocol == FrameProtocol::fd) text += fmt::format(" fd {}", frame.fd_flags);
  return text;
}

TEST(Candump, ReadsEveryKindOfFrame) {
  for_each_row(R"(
(1760000000.069964) can0 120#0400A0FF -> 1760000000069964000 can0: s120 data 4 04 00 A0 FF
(1760000000.069964123) can0 120# -> 1760000000069964123 can0: s120 data 0
(0000000000.000000001) can0 120# -> 1 can0: s120 data 0
(1.000000) can0 00000123#01 -> 1000000000 can0: x123 data 1 01
(1.000000) can0 18DAF110#01 -> 1000000000 can0: x18DAF110 data 1 01
(1.000000) can0 7FF#01 -> 1000000000 can0: s7FF data 1 01
(1.000000) can0 123#R -> 1000000000 can0: s123 remote 0
(1.000000) can0 123#R4 -> 1000000000 can0: s123 remote 4
(1.000000) can0 123#R8_9 -> 1000000000 can0: s123 remote 8
(1.000000) can0 20000004#0004000000000000 -> 1000000000 can0: s4 error 8 00 04 00 00 00 00 00 00
(1.000000) can0 123##1AABBCC -> 1000000000 can0: s123 data 3 AA BB CC fd 1
(1.000000) can0 123##0 -> 1000000000 can0: s123 data 0 fd 0
# Newer kernels also set the flag "this is CAN FD" (4).
(1.000000) can0 123##7AA -> 1000000000 can0: s123 data 1 AA fd 3
# What other writers add.
(1.000000) can0 123#1122334455667788_C -> 1000000000 can0: s123 data 8 11 22 33 44 55 66 77 88
(1.000000) can0 123#11.22.33 -> 1000000000 can0: s123 data 3 11 22 33
(1.000000) can0 123#ab R -> 1000000000 can0: s123 data 1 AB
 (1.000000) vcan-front.1 7ff#   -> 1000000000 vcan-front.1: s7FF data 0
)",
               [](const std::string& text, const std::string& expected) {
                 EXPECT_EQ(description(good(text)), expected) << text;
               });
  EXPECT_EQ(description(good("(1.000000)  can0\t123##0ab T\r")),
            "1000000000 can0: s123 data 1 AB fd 0");
  EXPECT_EQ(good("(1.000000) can0 12345678##3" + std::string(128, 'E')).frame.length, 64);
}

TEST(Candump, SaysWhatWasExpectedAndWhere) {
  const auto expect_bad = [](const std::string& text, const std::string& column_and_expected) {
    const CandumpLine line = parse_candump_line(text);
    EXPECT_FALSE(line.good()) << text;
    const std::size_t blank = column_and_expected.find(' ');
    EXPECT_EQ(std::to_string(line.column), column_and_expected.substr(0, blank)) << text;
    EXPECT_THAT(std::string(line.expected), HasSubstr(column_and_expected.substr(blank + 1)));
  };
  for_each_row(R"(
 -> 1 '('
1.000000 can0 123# -> 1 '('
(-1.000000) can0 123# -> 2 seconds
(1) can0 123# -> 3 decimals
(1.5) can0 123# -> 5 6 or 9 decimals
(1.0000000) can0 123# -> 11 6 or 9 decimals
(1.0000000000) can0 123# -> 14 6 or 9 decimals
(9000000001.000000) can0 123# -> 11 2255
(99999999999999999999999.000000) can0 123# -> 11 2255
(1.000000 can0 123# -> 10 ')'
(1.000000)can0 123# -> 11 space
(1.000000)  -> 12 interface
(1.000000) can0 -> 16 space
(1.000000) can0  -> 17 identifier
(1.000000) can0 12#00 -> 19 3 or 8
(1.000000) can0 1234#00 -> 21 3 or 8
(1.000000) can0 123456789#00 -> 25 3 or 8
(1.000000) can0 800#00 -> 17 7FF
(1.000000) can0 40000000#00 -> 17 1FFFFFFF
(1.000000) can0 123#0 -> 22 second digit
(1.000000) can0 123#0G -> 22 second digit
(1.000000) can0 123#00 junk -> 24 end of the line
(1.000000) can0 123#112233445566778899 -> 37 longer
(1.000000) can0 123#R9 -> 22 end of the line
(1.000000) can0 123## -> 22 flags
(1.000000) can0 123##0112233445566778899 -> 41 12, 16
(1.000000) can0 123#1122334455667788_8 -> 38 9 to F
(1.000000) can0 20000004##000 -> 27 error frame
)",
               expect_bad);
  expect_bad(std::string("(1.000000) can0 123#00\0", 23), "23 end of the line");
}

TEST(Candump, WritesWhatItReads) {
  for (const std::string_view text :
       {"(1760000000.069964) can0 120#0400A0FF\n", "(1760000000.000000) can1 18DAF110#\n",
        "(0000046408.584930) vcan0 123#R\n", "(1760000000.000001) can0 123#R4\n",
        "(1760000000.000000) can0 20000004#0004000000000000\n",
        "(1760000000.000000) can0 123##1AABBCC\n", "(1760000000.000000) can0 12345678##0\n"}) {
    const CandumpLine line = good(text.substr(0, text.size() - 1));
    std::string written;
    append_candump_line(written, line.frame, line.interface);
    EXPECT_EQ(written, text);
  }
}

TEST(Candump, WritesNanosecondsWhenAskedAndCutsThemOffOtherwise) {
  Frame frame;
  frame.time_ns = 1'760'000'000'999'999'999;
  frame.id = 0x7FF;
  std::string written;
  append_candump_line(written, frame, "can0", StampDecimals::nine);
  append_candump_line(written, frame, "can0", StampDecimals::six);
  EXPECT_EQ(written,
            "(1760000000.999999999) can0 7FF#\n"
            "(1760000000.999999) can0 7FF#\n");
}

}  // namespace
}  // namespace odomd::can::candump_test
