// The position of a signal in a payload and the meaning of its bits, shared by decoding and
// encoding.
//
// Bit s of a payload is bit s % 8 (0: least significant) of byte s / 8. A little-endian signal
// starts with its least significant bit and goes up through the bytes. A big-endian one starts with
// its most significant bit, goes down to bit 0 of that byte and on from bit 7 of the next.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "can_protocol/dbc/dbc.hpp"

namespace odomd::can {

struct SignalLayout {
  double scale = 1.0;
  double offset = 0.0;
  std::uint16_t start_bit = 0;
  std::uint8_t length = 0;        ///< bits, 1 to 64
  std::uint8_t bytes_needed = 0;  ///< minimum length of a payload that holds the signal
  ByteOrder byte_order = ByteOrder::little_endian;
  ValueType type = ValueType::unsigned_integer;
};

/// The number of bytes up to the end of a signal; above max_payload when it fits no frame.
[[nodiscard]] constexpr std::size_t bytes_needed(unsigned start_bit, unsigned length,
                                                 ByteOrder byte_order) noexcept {
  const unsigned first =  // counted from the most significant bit of byte 0 if big-endian
      byte_order == ByteOrder::little_endian ? start_bit : start_bit / 8 * 8 + 7 - start_bit % 8;
  return (std::size_t{first} + length + 7) / 8;
}

[[nodiscard]] inline SignalLayout layout_of(const Signal& signal) noexcept {
  return {
      signal.scale,
      signal.offset,
      signal.start_bit,
      signal.length,
      static_cast<std::uint8_t>(bytes_needed(signal.start_bit, signal.length, signal.byte_order)),
      signal.byte_order,
      signal.type};
}

/// The lowest `length` bits set, `length` from 1 to 64.
[[nodiscard]] constexpr std::uint64_t low_bits(unsigned length) noexcept {
  return ~std::uint64_t{0} >> (64U - length);
}

/// The signal's bits as they are on the bus, right-aligned. `payload` must have bytes_needed bytes;
/// seven more, of any content, make the extraction faster.
[[nodiscard]] inline std::uint64_t extract_bits(const SignalLayout& signal,
                                                std::span<const std::uint8_t> payload) noexcept {
  const unsigned length = signal.length;
  const unsigned bit = signal.start_bit % 8U;
  std::size_t byte = signal.start_bit / 8U;
  if (byte + 8 <= payload.size() && signal.bytes_needed <= byte + 8) {  // one read
    std::uint64_t bits = 0;
    std::memcpy(&bits, &payload[byte], sizeof bits);
    if (signal.byte_order == ByteOrder::little_endian) return bits >> bit & low_bits(length);
    return __builtin_bswap64(bits) << (7 - bit) >> (64 - length);
  }
  if (signal.byte_order == ByteOrder::little_endian) {
    std::uint64_t bits = std::uint64_t{payload[byte]} >> bit;
    for (unsigned have = 8 - bit; have < length; have += 8)
      bits |= std::uint64_t{payload[++byte]} << have;
    return bits & low_bits(length);
  }
  std::uint64_t bits = payload[byte] & low_bits(bit + 1);
  unsigned have = bit + 1;
  if (have > length) return bits >> (have - length);
  for (; have + 8 <= length; have += 8) bits = bits << 8U | payload[++byte];
  if (const unsigned rest = length - have; rest > 0)
    bits = bits << rest | std::uint64_t{payload[++byte]} >> (8 - rest);
  return bits;
}

/// Writes the lower `length` bits of `bits` and leaves all other bits of the payload unchanged.
/// `payload` must have bytes_needed bytes.
constexpr void insert_bits(const SignalLayout& signal, std::uint64_t bits,
                           std::span<std::uint8_t> payload) noexcept {
  // From the least significant bit up, as many bits at a time as lie in one byte.
  const bool little = signal.byte_order == ByteOrder::little_endian;
  std::size_t byte = little ? signal.start_bit / 8U : signal.bytes_needed - 1U;
  unsigned low = signal.start_bit % 8U;
  if (!little) low = 7U - (7U - low + signal.length - 1U) % 8U;
  for (unsigned done = 0; done < signal.length;) {
    const unsigned here = signal.length - done < 8 - low ? signal.length - done : 8 - low;
    const auto mask = static_cast<std::uint8_t>(low_bits(here) << low);
    payload[byte] =
        static_cast<std::uint8_t>((payload[byte] & ~mask) | (((bits >> done) << low) & mask));
    done += here;
    low = 0;
    byte += little ? 1U : ~std::size_t{0};  // back one byte
  }
}

static_assert(std::endian::native == std::endian::little, "eight bytes are loaded at once");

/// Sign-extends a two's complement number of `length` bits.
[[nodiscard]] constexpr std::int64_t sign_extended(std::uint64_t bits, unsigned length) noexcept {
  const std::uint64_t sign = std::uint64_t{1} << (length - 1);
  return static_cast<std::int64_t>((bits ^ sign) - sign);
}

/// The raw value, before scale and offset. Integers beyond 2^53 are rounded.
[[nodiscard]] constexpr double raw_value(const SignalLayout& signal, std::uint64_t bits) noexcept {
  switch (signal.type) {
    case ValueType::unsigned_integer:
      return static_cast<double>(bits);
    case ValueType::signed_integer:
      return static_cast<double>(sign_extended(bits, signal.length));
    case ValueType::float32:
      return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
    case ValueType::float64:
      return std::bit_cast<double>(bits);
  }
  return 0.0;
}

/// physical = raw * scale + offset
[[nodiscard]] constexpr double physical_value(const SignalLayout& signal,
                                              std::uint64_t bits) noexcept {
  return raw_value(signal, bits) * signal.scale + signal.offset;
}

/// The bits whose physical value is nearest to `physical`, saturated to what the bits can hold. NaN
/// becomes raw 0 in an integer signal.
[[nodiscard]] std::uint64_t bits_for(const SignalLayout& signal, double physical) noexcept;

/// The number that a person would write for a physical value, with no more decimals than factor and
/// offset have: -0.1175 instead of -0.11750000000000001, the result of -235 * 0.0005. For messages
/// and files; a float keeps the digits of a float.
[[nodiscard]] double as_written(const SignalLayout& signal, double physical) noexcept;

/// Whether a raw value of the multiplexor lies in one of the ranges.
[[nodiscard]] inline bool is_selected(std::span<const MultiplexRange> ranges,
                                      std::uint64_t raw) noexcept {
  for (const MultiplexRange& range : ranges)
    if (range.first <= raw && raw <= range.last) return true;
  return false;
}

/// Whether the multiplexors of the payload select this signal; true for a signal that is not
/// multiplexed, false when the payload ends before a multiplexor does.
[[nodiscard]] bool is_present(const Message& message, const Signal& signal,
                              std::span<const std::uint8_t> payload) noexcept;

}  // namespace odomd::can
