// The candump grammar: all forms of a frame, read and written, and the errors of invalid lines.
#include "can_protocol/sources/candump.hpp"

#include <ostream>

#include "tests/gtest.hpp"

namespace odomd::can::candump_test {
namespace {

CandumpLine good(std::string_view text) {
  CandumpLine line = parse_candump_line(text);
  EXPECT_TRUE(line.good()) << text << ": expected " << line.expected << " at " << line.column;
  return line;
}

std::vector<std::uint8_t> payload(const Frame& frame) {
  return {frame.payload().begin(), frame.payload().end()};
}

TEST(Candump, ReadsAClassicFrameWithItsStampAsAnInteger) {
  const CandumpLine line = good("(1760000000.069964) can0 120#0400A0FF");
  EXPECT_EQ(line.frame.time_ns, 1'760'000'000'069'964'000);
  EXPECT_EQ(line.interface, "can0");
  EXPECT_EQ(line.frame.id, 0x120U);
  EXPECT_EQ(line.frame.format, IdFormat::standard);
  EXPECT_EQ(line.frame.kind, FrameKind::data);
  EXPECT_EQ(line.frame.protocol, FrameProtocol::classic);
  EXPECT_EQ(payload(line.frame), (std::vector<std::uint8_t>{0x04, 0x00, 0xA0, 0xFF}));
}

TEST(Candump, ReadsNanoseconds) {
  EXPECT_EQ(good("(1760000000.069964123) can0 120#").frame.time_ns, 1'760'000'000'069'964'123);
  EXPECT_EQ(good("(0000000000.000000001) can0 120#").frame.time_ns, 1);
}

TEST(Candump, DistinguishesExtendedFromStandardByTheNumberOfDigits) {
  const Frame extended = good("(1.000000) can0 00000123#01").frame;
  EXPECT_EQ(extended.format, IdFormat::extended);
  EXPECT_EQ(extended.id, 0x123U);
  EXPECT_EQ(good("(1.000000) can0 18DAF110#01").frame.id, 0x18DA'F110U);
  EXPECT_EQ(good("(1.000000) can0 7FF#01").frame.format, IdFormat::standard);
}

TEST(Candump, ReadsRemoteFrames) {
  const Frame plain = good("(1.000000) can0 123#R").frame;
  EXPECT_EQ(plain.kind, FrameKind::remote);
  EXPECT_EQ(plain.length, 0);
  EXPECT_EQ(good("(1.000000) can0 123#R4").frame.length, 4);
  EXPECT_EQ(good("(1.000000) can0 123#R8_9").frame.length, 8);
}

TEST(Candump, ReadsErrorFramesByTheirFlag) {
  const Frame frame = good("(1.000000) can0 20000004#0004000000000000").frame;
  EXPECT_EQ(frame.kind, FrameKind::error);
  EXPECT_EQ(frame.id, 4U);
  EXPECT_EQ(frame.length, 8);
}

TEST(Candump, ReadsCanFdWithItsFlags) {
  const Frame frame = good("(1.000000) can0 123##1AABBCC").frame;
  EXPECT_EQ(frame.protocol, FrameProtocol::fd);
  EXPECT_EQ(frame.fd_flags, 1);
  EXPECT_EQ(frame.length, 3);
  EXPECT_EQ(good("(1.000000) can0 123##0").frame.length, 0);
  // Newer kernels also set the flag "this is CAN FD" (4).
  EXPECT_EQ(good("(1.000000) can0 123##7AA").frame.fd_flags, 3);
  EXPECT_EQ(
      good("(1.0000000" + std::string("00) can0 12345678##3") + std::string(128, 'E')).frame.length,
      64);
}

TEST(Candump, TakesWhatOtherWritersAdd) {
  EXPECT_EQ(good("(1.000000) can0 123#1122334455667788_C").frame.length, 8);
  EXPECT_EQ(good("(1.000000) can0 123#11.22.33").frame.length, 3);
  EXPECT_EQ(good("(1.000000) can0 123#ab R").frame.data[0], 0xAB);
  EXPECT_EQ(good("(1.000000)  can0\t123##0ab T\r").frame.data[0], 0xAB);
  EXPECT_EQ(good("  (1.000000) vcan-front.1 7ff#  ").interface, "vcan-front.1");
}

struct BadLine {
  std::string text;
  std::size_t column;
  std::string expected;
};

void PrintTo(const BadLine& line, std::ostream* out) {
  *out << '"' << line.text << '"';
}

class BadCandump : public testing::TestWithParam<BadLine> {};

TEST_P(BadCandump, SaysWhatWasExpectedAndWhere) {
  const CandumpLine line = parse_candump_line(GetParam().text);
  EXPECT_FALSE(line.good());
  EXPECT_EQ(line.column, GetParam().column);
  EXPECT_THAT(std::string(line.expected), HasSubstr(GetParam().expected));
}

INSTANTIATE_TEST_SUITE_P(
    Lines, BadCandump,
    testing::Values(
        BadLine{"", 1, "'('"}, BadLine{"1.000000 can0 123#", 1, "'('"},
        BadLine{"(-1.000000) can0 123#", 2, "seconds"}, BadLine{"(1) can0 123#", 3, "decimals"},
        BadLine{"(1.5) can0 123#", 5, "6 or 9 decimals"},
        BadLine{"(1.0000000) can0 123#", 11, "6 or 9 decimals"},
        BadLine{"(1.0000000000) can0 123#", 14, "6 or 9 decimals"},
        BadLine{"(9000000001.000000) can0 123#", 11, "2255"},
        BadLine{"(99999999999999999999999.000000) can0 123#", 11, "2255"},
        BadLine{"(1.000000 can0 123#", 10, "')'"}, BadLine{"(1.000000)can0 123#", 11, "space"},
        BadLine{"(1.000000) ", 12, "interface"}, BadLine{"(1.000000) can0", 16, "space"},
        BadLine{"(1.000000) can0 ", 17, "identifier"},
        BadLine{"(1.000000) can0 12#00", 17 + 2, "3 or 8"},
        BadLine{"(1.000000) can0 1234#00", 17 + 4, "3 or 8"},
        BadLine{"(1.000000) can0 123456789#00", 17 + 8, "3 or 8"},
        BadLine{"(1.000000) can0 800#00", 17, "7FF"},
        BadLine{"(1.000000) can0 40000000#00", 17, "1FFFFFFF"},
        BadLine{"(1.000000) can0 123#0", 22, "second digit"},
        BadLine{"(1.000000) can0 123#0G", 22, "second digit"},
        BadLine{"(1.000000) can0 123#00 junk", 24, "end of the line"},
        BadLine{"(1.000000) can0 123#112233445566778899", 37, "longer"},
        BadLine{"(1.000000) can0 123#R9", 22, "end of the line"},
        BadLine{"(1.000000) can0 123##", 22, "flags"},
        BadLine{"(1.000000) can0 123##0112233445566778899", 41, "12, 16"},
        BadLine{"(1.000000) can0 123#1122334455667788_8", 38, "9 to F"},
        BadLine{"(1.000000) can0 20000004##000", 27, "error frame"},
        BadLine{std::string("(1.000000) can0 123#00\0", 23), 23, "end of the line"}));

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
