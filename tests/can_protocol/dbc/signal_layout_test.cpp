// Extraction and insertion of bits, compared with a bit-by-bit reference.
#include "can_protocol/dbc/signal_layout.hpp"

#include <limits>
#include <random>

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

std::uint64_t slow_extract(const std::vector<unsigned>& bits, const Payload& payload) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < bits.size(); ++i)
    if ((payload[bits[i] / 8] >> (bits[i] % 8) & 1) != 0) value |= std::uint64_t{1} << i;
  return value;
}

void slow_insert(const std::vector<unsigned>& bits, std::uint64_t value, Payload& payload) {
  for (std::size_t i = 0; i < bits.size(); ++i) {
    const auto mask = static_cast<std::uint8_t>(1U << (bits[i] % 8));
    std::uint8_t& byte = payload[bits[i] / 8];
    byte = static_cast<std::uint8_t>((value >> i & 1) != 0 ? byte | mask : byte & ~mask);
  }
}

SignalLayout layout(unsigned start, unsigned length, ByteOrder order) {
  Signal signal;
  signal.start_bit = static_cast<std::uint16_t>(start);
  signal.length = static_cast<std::uint8_t>(length);
  signal.byte_order = order;
  return layout_of(signal);
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
        const unsigned last_byte =
            *std::max_element(bits.begin(), bits.end(),
                              [](unsigned a, unsigned b) { return a / 8 < b / 8; }) /
            8;
        ASSERT_EQ(bytes_needed(start, length, order), last_byte + 1);
        if (last_byte >= max_payload) continue;
        const SignalLayout signal = layout(start, length, order);
        const Payload payload = random_payload(random);
        // Nothing after bytes_needed is accessed: a span of that size is enough.
        const std::vector<std::uint8_t> exact(payload.begin(),
                                              payload.begin() + signal.bytes_needed);
        ASSERT_EQ(extract_bits(signal, exact), slow_extract(bits, payload))
            << start << '|' << length;
        ASSERT_EQ(extract_bits(signal, payload), slow_extract(bits, payload))
            << start << '|' << length << " of the whole";

        const std::uint64_t value = random();
        Payload expected = payload;
        slow_insert(bits, value, expected);
        std::vector<std::uint8_t> written = exact;
        insert_bits(signal, value, written);
        ASSERT_TRUE(std::equal(written.begin(), written.end(), expected.begin()))
            << start << '|' << length;
        ++cases;
      }
    }
  }
  EXPECT_GT(cases, 60'000);
}

TEST(SignalLayout, ExtendsTheSign) {
  EXPECT_EQ(sign_extended(0b1000, 4), -8);
  EXPECT_EQ(sign_extended(0b0111, 4), 7);
  EXPECT_EQ(sign_extended(1, 1), -1);
  EXPECT_EQ(sign_extended(0x8000'0000'0000'0000U, 64), std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(sign_extended(0xFFFF'FFFF'FFFF'FFFFU, 64), -1);
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
  SignalLayout unsigned8 = layout(0, 8, ByteOrder::little_endian);
  unsigned8.scale = 0.5;
  unsigned8.offset = -10.0;
  EXPECT_EQ(bits_for(unsigned8, -10.0), 0U);
  EXPECT_EQ(bits_for(unsigned8, -9.3), 1U);
  EXPECT_EQ(bits_for(unsigned8, -9.2), 2U);
  EXPECT_EQ(bits_for(unsigned8, -1000.0), 0U);
  EXPECT_EQ(bits_for(unsigned8, 1000.0), 255U);
  EXPECT_EQ(bits_for(unsigned8, HUGE_VAL), 255U);
  EXPECT_EQ(bits_for(unsigned8, -HUGE_VAL), 0U);
  EXPECT_EQ(bits_for(unsigned8, std::nan("")), 0U);

  SignalLayout signed8 = unsigned8;
  signed8.type = ValueType::signed_integer;
  signed8.scale = -1.0;
  signed8.offset = 0.0;
  EXPECT_EQ(bits_for(signed8, 1.0), 0xFFU);
  EXPECT_EQ(bits_for(signed8, 1e9), 0x80U);
  EXPECT_EQ(bits_for(signed8, -1e9), 0x7FU);
  EXPECT_EQ(bits_for(signed8, std::nan("")), 0U);

  const SignalLayout widest = layout(0, 64, ByteOrder::little_endian);
  EXPECT_EQ(bits_for(widest, 1e30), ~std::uint64_t{0});
  EXPECT_EQ(bits_for(widest, 0x1p63), std::uint64_t{1} << 63U);
  SignalLayout widest_signed = widest;
  widest_signed.type = ValueType::signed_integer;
  EXPECT_EQ(bits_for(widest_signed, -1e30), std::uint64_t{1} << 63U);
  EXPECT_EQ(bits_for(widest_signed, 1e30), ~std::uint64_t{0} >> 1U);
}

TEST(AsWritten, HasTheDecimalsOfFactorAndOffset) {
  const auto layout = [](double scale, double offset) {
    SignalLayout signal;
    signal.scale = scale;
    signal.offset = offset;
    signal.type = ValueType::signed_integer;
    return signal;
  };
  EXPECT_EQ(as_written(layout(0.0005, 0.0), -235 * 0.0005), -0.1175);
  EXPECT_EQ(as_written(layout(0.1, -100.0), 1001 * 0.1 - 100.0), 0.1);
  EXPECT_EQ(as_written(layout(0.1, 0.25), 3 * 0.1 + 0.25), 0.55);
  EXPECT_EQ(as_written(layout(100.0, 0.0), 4.2e9 * 100.0), 4.2e11);
  EXPECT_EQ(as_written(layout(1e-9, 0.0), 7 * 1e-9), 7e-9);
  EXPECT_EQ(as_written(layout(0.0, 0.0), 0.0), 0.0);
  for (int raw = -32768; raw < 32768; ++raw)
    ASSERT_EQ(as_written(layout(0.01, 0.0), raw * 0.01), raw / 100.0) << raw;
}

TEST(AsWritten, KeepsWhatNoDecimalsDescribe) {
  SignalLayout signal;
  signal.type = ValueType::float32;
  EXPECT_EQ(as_written(signal, static_cast<double>(0.1F)), 0.1);
  signal.type = ValueType::float64;
  EXPECT_EQ(as_written(signal, 0.1 + 0.2), 0.1 + 0.2);
  signal.type = ValueType::unsigned_integer;
  EXPECT_EQ(as_written(signal, 18446744073709551615.0), 18446744073709551615.0);
  signal.scale = 1e-300;
  EXPECT_EQ(as_written(signal, 3e-300), 3e-300);
  EXPECT_TRUE(std::isnan(as_written(signal, std::nan(""))));
}

TEST(SignalLayout, KnowsWhichMultiplexedSignalsAPayloadHolds) {
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
