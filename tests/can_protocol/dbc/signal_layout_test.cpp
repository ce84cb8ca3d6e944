// Extraction and insertion of bits, compared with a bit-by-bit reference.
#include "can_protocol/dbc/signal_layout.hpp"

#include <limits>
#include <random>
#include <tuple>

#include "tests/gtest.hpp"

namespace odomd::can::signal_layout_test {
namespace {

using Payload = std::array<std::uint8_t, max_payload>;

/// Positions of a signal's bits, least significant first, directly from the definition: a
/// big-endian signal goes from its most significant bit down to bit 0 of that byte, and continues
/// at bit 7 of the next.
std::vector<unsigned> positions(unsigned start, unsigned length, ByteOrder order) {
  std::vector<unsigned> bits;
  unsigned at = start;
  for (unsigned i = 0; i < length; ++i) {
    bits.push_back(at);
    if (order == ByteOrder::little_endian)
      ++at;
    else
      at = at % 8 == 0 ? at + 15 : at - 1;
  }
  if (order == ByteOrder::big_endian) std::reverse(bits.begin(), bits.end());
  return bits;
}

void slow_insert(const std::vector<unsigned>& bits, std::uint64_t value, Payload& payload) {
  for (std::size_t i = 0; i < bits.size(); ++i) {
    const auto mask = static_cast<std::uint8_t>(1U << (bits[i] % 8));
    std::uint8_t& byte = payload[bits[i] / 8];
    byte = static_cast<std::uint8_t>((value >> i & 1) != 0 ? byte | mask : byte & ~mask);
  }
}

SignalLayout layout(unsigned start, unsigned length, ByteOrder order) {
  return layout_of({.start_bit = static_cast<std::uint16_t>(start),
                    .length = static_cast<std::uint8_t>(length),
                    .byte_order = order});
}

Payload random_payload(std::mt19937_64& random) {
  Payload payload;
  for (auto& byte : payload) byte = static_cast<std::uint8_t>(random());
  return payload;
}

TEST(SignalLayout, AgreesWithABitByBitReferenceAtEveryPositionAndLength) {
  std::mt19937_64 random(1);
  int cases = 0;
  for (const ByteOrder order : {ByteOrder::little_endian, ByteOrder::big_endian}) {
    for (unsigned start = 0; start < max_payload * 8; ++start) {
      for (unsigned length = 1; length <= 64; ++length) {
        const auto bits = positions(start, length, order);
        const unsigned last_byte = std::max(bits.front(), bits.back()) / 8;
        ASSERT_EQ(bytes_needed(start, length, order), last_byte + 1);
        if (last_byte >= max_payload) continue;
        SCOPED_TRACE(start);
        SCOPED_TRACE(length);
        const SignalLayout signal = layout(start, length, order);
        const Payload before = random_payload(random);
        const std::uint64_t value = random();
        Payload after = before;
        slow_insert(bits, value, after);
        // Nothing after bytes_needed is accessed: a span of that size is enough.
        const std::vector<std::uint8_t> exact(after.begin(), after.begin() + signal.bytes_needed);
        ASSERT_EQ(extract_bits(signal, exact), value & low_bits(length));
        ASSERT_EQ(extract_bits(signal, after), value & low_bits(length)) << "of the whole";
        std::vector<std::uint8_t> written(before.begin(), before.begin() + signal.bytes_needed);
        insert_bits(signal, value, written);
        ASSERT_EQ(written, exact);
        ++cases;
      }
    }
  }
  EXPECT_GT(cases, 60'000);
}

TEST(SignalLayout, ReadsFloatsInBothByteOrders) {
  SignalLayout single = layout(0, 32, ByteOrder::little_endian);
  single.type = ValueType::float32;
  SignalLayout twice = layout(7, 64, ByteOrder::big_endian);
  twice.type = ValueType::float64;
  Payload payload{};
  insert_bits(single, bits_for(single, -1.5), payload);
  EXPECT_EQ(payload[3], 0xBF);
  EXPECT_EQ(payload[2], 0xC0);
  EXPECT_EQ(physical_value(single, extract_bits(single, payload)), -1.5);
  insert_bits(twice, bits_for(twice, 0.1), payload);
  EXPECT_EQ(payload[0], 0x3F);
  EXPECT_EQ(physical_value(twice, extract_bits(twice, payload)), 0.1);
  EXPECT_TRUE(std::isinf(physical_value(single, bits_for(single, HUGE_VAL))));
  EXPECT_EQ(physical_value(single, bits_for(single, 1e300)), std::numeric_limits<float>::max());
}

TEST(SignalLayout, RoundsToTheNearestRawValueAndSaturates) {
  const auto of = [](unsigned length, char sign, double scale = 1.0, double offset = 0.0) {
    SignalLayout signal = layout(0, length, ByteOrder::little_endian);
    signal.type = sign == '-' ? ValueType::signed_integer : ValueType::unsigned_integer;
    signal.scale = scale;
    signal.offset = offset;
    return signal;
  };
  struct {
    SignalLayout signal;
    std::vector<std::pair<double, std::uint64_t>> bits;
  } const cases[]{
      {of(8, '+', 0.5, -10.0),
       {{-10.0, 0}, {-9.3, 1}, {-9.2, 2}, {-1000.0, 0}, {1000.0, 255}, {HUGE_VAL, 255}}},
      {of(8, '+', 0.5, -10.0), {{-HUGE_VAL, 0}, {std::nan(""), 0}}},
      {of(8, '-', -1.0), {{1.0, 0xFF}, {1e9, 0x80}, {-1e9, 0x7F}, {std::nan(""), 0}}},
      {of(64, '+'), {{1e30, ~std::uint64_t{0}}, {0x1p63, std::uint64_t{1} << 63U}}},
      {of(64, '-'), {{-1e30, std::uint64_t{1} << 63U}, {1e30, ~std::uint64_t{0} >> 1U}}},
  };
  for (const auto& [signal, rows] : cases)
    for (const auto& [physical, bits] : rows)
      EXPECT_EQ(bits_for(signal, physical), bits) << int{signal.length} << ' ' << physical;
}

TEST(AsWritten, HasTheDecimalsOfFactorAndOffset) {
  const auto scaled = [](double scale, double offset = 0.0,
                         ValueType type = ValueType::signed_integer) {
    return SignalLayout{.scale = scale, .offset = offset, .type = type};
  };
  const std::tuple<SignalLayout, double, double> cases[]{
      {scaled(0.0005), -235 * 0.0005, -0.1175},
      {scaled(0.1, -100.0), 1001 * 0.1 - 100.0, 0.1},
      {scaled(0.1, 0.25), 3 * 0.1 + 0.25, 0.55},
      {scaled(100.0), 4.2e9 * 100.0, 4.2e11},
      {scaled(1e-9), 7 * 1e-9, 7e-9},
      {scaled(0.0), 0.0, 0.0},
      {scaled(1e-300), 3e-300, 3e-300},
      {scaled(1.0, 0.0, ValueType::float32), static_cast<double>(0.1F), 0.1},
      {scaled(1.0, 0.0, ValueType::float64), 0.1 + 0.2, 0.1 + 0.2},
      {scaled(1.0, 0.0, ValueType::unsigned_integer), 0x1p64, 0x1p64},
  };
  for (const auto& [signal, physical, written] : cases)
    EXPECT_EQ(as_written(signal, physical), written);
  for (int raw = -32768; raw < 32768; ++raw)
    ASSERT_EQ(as_written(scaled(0.01), raw * 0.01), raw / 100.0) << raw;
  EXPECT_TRUE(std::isnan(as_written(scaled(1e-300), std::nan(""))));
}

TEST(SignalLayout, KnowsWhichMultiplexedSignalsArePresent) {
  const Database database = parse_dbc(R"(BO_ 1 A: 8 X
 SG_ Root M : 0|8@1+ (1,0) [0|0] "" X
 SG_ Inner m1M : 8|8@1+ (1,0) [0|0] "" X
 SG_ Deep m3 : 16|8@1+ (1,0) [0|0] "" X
SG_MUL_VAL_ 1 Inner Root 1-1, 5-9;
SG_MUL_VAL_ 1 Deep Inner 3-4;
)",
                                      "a.dbc");
  const Message& message = database.messages[0];
  const auto present = [&](std::vector<std::uint8_t> payload) {
    std::string names;
    for (const Signal& signal : message.signals)
      if (is_present(message, signal, payload)) names += signal.name + ' ';
    return names;
  };
  EXPECT_EQ(present({0, 3, 0}), "Root ");
  EXPECT_EQ(present({1, 0, 0}), "Root Inner ");
  EXPECT_EQ(present({5, 4, 0}), "Root Inner Deep ");
  EXPECT_EQ(present({10, 4, 0}), "Root ");
  EXPECT_EQ(present({1}), "Root Inner ");  // too short to select Deep
  EXPECT_EQ(present({}), "Root ");
}

}  // namespace
}  // namespace odomd::can::signal_layout_test
