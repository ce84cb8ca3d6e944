// The two 8-bit cyclic redundancy checks of AUTOSAR: most significant bit first, no reflection.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace odomd::can {

template <std::uint8_t polynomial>
class Crc8 {
 public:
  /// Goes on from `crc` over `bytes`; start value and final xor are the caller's.
  static constexpr std::uint8_t update(std::uint8_t crc,
                                       std::span<const std::uint8_t> bytes) noexcept {
    for (const std::uint8_t byte : bytes) crc = table[crc ^ byte];
    return crc;
  }
  static constexpr std::uint8_t update(std::uint8_t crc, std::uint8_t byte) noexcept {
    return table[crc ^ byte];
  }

 private:
  static constexpr std::array<std::uint8_t, 256> table = [] {
    std::array<std::uint8_t, 256> entries{};
    for (std::size_t i = 0; i < entries.size(); ++i) {
      auto crc = static_cast<unsigned>(i);
      for (int bit = 0; bit < 8; ++bit)
        crc = (crc & 0x80U) != 0 ? (crc << 1U ^ polynomial) & 0xFFU : crc << 1U;
      entries[i] = static_cast<std::uint8_t>(crc);
    }
    return entries;
  }();
};

using CrcJ1850 = Crc8<0x1D>;  ///< x^8 + x^4 + x^3 + x^2 + 1, SAE J1850
using CrcH2f = Crc8<0x2F>;    ///< x^8 + x^5 + x^3 + x^2 + x + 1

}  // namespace odomd::can
