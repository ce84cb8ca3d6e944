// End-to-end protection of a message: AUTOSAR profiles 1, 11, 2 and 22, a plain counter, and the
// plain SAE J1850 checksum.
//
// Source: AUTOSAR FO, E2E Protocol Specification (document 849). The CRC runs over
//   1, 11      start 0x00, the data id, all protected bytes but the CRC's own; polynomial 0x1D.
//              Data id: BOTH low byte, high byte; LOW low byte; ALT low byte if the counter is
//              even, else high byte; NIBBLE low byte, 0x00, and the low nibble of the high byte is
//              sent in the other half of the counter's byte.
//   2, 22      start 0xFF, all protected bytes but the CRC's own, then data_id_list[counter]; final
//              xor 0xFF; polynomial 0x2F.
//   SAE J1850  start 0xFF, all protected bytes but the CRC's own; final xor 0xFF; polynomial 0x1D.
// The protected bytes are those within the message length in the database; padding after them is
// ignored. The positions of CRC and counter are those of their signals.
//
// Counters run 0 to 14 (profiles 1 and 11; 15 is an error), 0 to 15 (2 and 22), or through all
// values of their signal (plain).
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "can_protocol/dbc/dbc.hpp"
#include "can_protocol/dbc/signal_layout.hpp"
#include "can_protocol/decode/signal_binding.hpp"

namespace odomd::can {

/// AUTOSAR's check states. d is the step of the counter since the last frame with a correct CRC:
enum class E2eStatus : std::uint8_t {
  ok,              ///< d = 1, or the very first frame (AUTOSAR's INITIAL)
  ok_some_lost,    ///< 1 < d <= max_delta_counter
  repeated,        ///< d = 0
  wrong_sequence,  ///< d > max_delta_counter
  error,           ///< wrong CRC, data id or counter range, or a payload that is too short
  no_new_data      ///< an empty payload
};

/// The state of a receiver or sender between frames.
///
/// Every frame with a correct CRC becomes the new reference, even if it is rejected as
/// wrong_sequence: after a gap one frame is rejected and the next is ok again, so a loss never
/// blocks a message permanently. Frames with an error and empty frames change nothing.
struct E2eState {
  std::optional<std::uint32_t> counter;  ///< of the last frame with a correct CRC, or sent
};

/// The compiled protection of one message. Immutable: any thread may use it with its own state.
class E2eProtection {
 public:
  /// Throws std::invalid_argument for signals that do not exist or cannot hold a CRC or counter,
  /// naming message, signal and the nearest valid name.
  E2eProtection(const Message& message, const E2eBinding& binding);

  /// Real-time safe.
  E2eStatus check(std::span<const std::uint8_t> payload, E2eState& state) const noexcept;

  /// Writes counter and CRC into a payload of at least length() bytes; the first counter is 0.
  void protect(std::span<std::uint8_t> payload, E2eState& state) const noexcept;

  /// The number of protected bytes.
  [[nodiscard]] std::uint8_t length() const noexcept { return length_; }

 private:
  [[nodiscard]] std::uint8_t crc(std::span<const std::uint8_t> payload,
                                 std::uint32_t counter) const noexcept;

  E2eProfile profile_ = E2eProfile::none;
  std::uint8_t data_id_nibble_ = 0;  ///< the part of the data id that NIBBLE sends
  std::uint8_t length_ = 0;
  std::uint8_t max_delta_ = 1;
  std::uint64_t counter_values_ = 0;  ///< number of counter values; 0: no counter
  std::array<std::uint8_t, 16> data_id_list_{};
  std::optional<std::uint8_t> crc_byte_;
  std::array<std::uint8_t, 2> crc_start_{};  ///< for an even and an odd counter
  std::uint8_t crc_final_xor_ = 0;
  SignalLayout counter_;
  SignalLayout nibble_;  ///< where NIBBLE sends its part of the data id
};

/// Decides whether a protected message can be trusted: AUTOSAR's E2E state machine, with one
/// window.
///
/// An 8-bit CRC passes one random payload in 256, and the counter one in five of those. This is not
/// enough against noise, a second sender or a wrong data id: on a full bus a payload passes several
/// times a second. But then nearly all checks fail, so a message is not trusted after too many
/// failed checks, nor is the first frame that passes right after an error.
class E2eTrust {
 public:
  /// The number of remembered checks, and how many of them may fail. After a disturbance at most
  /// `window - max_failed` good frames are rejected; after a single error, one.
  static constexpr int window = 16;
  static constexpr int max_failed = 4;

  /// Records the result of a check and returns whether the message can be trusted. As in AUTOSAR,
  /// repeated and absent data count neither as passed nor as failed: gateways repeat frames.
  bool after(E2eStatus status) noexcept {
    const bool behind_error = after_error_;
    if (status != E2eStatus::repeated && status != E2eStatus::no_new_data) {
      const bool failed = status == E2eStatus::error || status == E2eStatus::wrong_sequence;
      failures_ = static_cast<std::uint16_t>(failures_ * 2U + (failed ? 1U : 0U));
      after_error_ = status == E2eStatus::error;
    }
    // `failures_` is usually 0; std::popcount is a function call on CPUs without the instruction.
    const bool few = failures_ == 0 || std::popcount(failures_) <= max_failed;
    return few && !behind_error;
  }

 private:
  std::uint16_t failures_ = 0;  ///< the newest check is the lowest bit
  bool after_error_ = false;    ///< the newest check was an ERROR
};

/// AUTOSAR's 8-bit checks: most significant bit first, no reflection.
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
