// The two 8-bit cyclic redundancy checks of AUTOSAR: most significant bit first, no reflection.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace odomd::can {

template <std::uint8_t polynomial>
class Crc8 {
 public:
  /// Continues `crc` over `bytes`; the caller applies start value and final xor.
  static constexpr std::uint8_t update(std::uint8_t crc,
                                       std::span<const std::uint8_t> bytes) noexcept {
    while (!bytes.empty()) {
      const std::size_t count = std::min(bytes.size(), stride);
      std::uint8_t sum = tables[count - 1][crc ^ bytes[0]];
      for (std::size_t i = 1; i < count; ++i) sum ^= tables[count - 1 - i][bytes[i]];
      crc = sum;
      bytes = bytes.subspan(count);
    }
    return crc;
  }
  static constexpr std::uint8_t update(std::uint8_t crc, std::uint8_t byte) noexcept {
    return tables[0][crc ^ byte];
  }

 private:
  // The CRC is the xor of one term per byte. A term depends on the byte and on the number n of
  // bytes after it: tables[n][byte]. So the look-ups are independent of each other.
  static constexpr std::size_t stride = 8;
  using Table = std::array<std::uint8_t, 256>;
  static constexpr std::array<Table, stride> tables = [] {
    std::array<Table, stride> made{};
    for (std::size_t byte = 0; byte < 256; ++byte) {
      auto crc = static_cast<unsigned>(byte);
      for (Table& table : made) {
        for (int bit = 0; bit < 8; ++bit)
          crc = (crc & 0x80U) != 0 ? (crc << 1U ^ polynomial) & 0xFFU : crc << 1U;
        table[byte] = static_cast<std::uint8_t>(crc);
      }
    }
    return made;
  }();
};

using CrcJ1850 = Crc8<0x1D>;  ///< x^8 + x^4 + x^3 + x^2 + 1, SAE J1850
using CrcH2f = Crc8<0x2F>;    ///< x^8 + x^5 + x^3 + x^2 + x + 1

}  // namespace odomd::can
