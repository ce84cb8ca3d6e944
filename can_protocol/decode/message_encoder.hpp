// Encodes physical values into frames, for the simulator and for tests; the counterpart of the
// decoder.
//
//   MessageEncoder imu(*find_message(database, "IMU"), protection);
//   imu.set("YawRate", 0.3);
//   Frame frame = imu.frame(time_ns);
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "can_protocol/dbc/dbc.hpp"
#include "can_protocol/decode/e2e.hpp"
#include "can_protocol/frame.hpp"

namespace odomd::can {

/// Holds the values of one message between frames; initially all raw values are 0. For one thread.
class MessageEncoder {
 public:
  explicit MessageEncoder(Message message);

  /// Every frame gets the next counter and its CRC. Throws as E2eProtection does.
  MessageEncoder(Message message, const E2eBinding& protection);

  /// Rounds to the nearest raw value and saturates at the range of the signal. For a multiplexed
  /// signal, sets its multiplexors so that they select it. Throws std::invalid_argument for an
  /// unknown name, naming the nearest one, for NaN in an integer signal, and for a signal that no
  /// value of its multiplexor selects.
  void set(std::string_view signal, double physical);

  /// Sets the raw bits of the signal; bits beyond its length are ignored.
  void set_bits(std::string_view signal, std::uint64_t bits);

  /// A frame with the current values.
  [[nodiscard]] Frame frame(std::int64_t time_ns, std::uint8_t bus = 0);

  [[nodiscard]] const Message& message() const noexcept { return message_; }

 private:
  [[nodiscard]] const Signal& require(std::string_view signal) const;
  void insert(const Signal& signal, std::uint64_t bits);

  Message message_;
  std::array<std::uint8_t, max_payload> payload_{};
  std::optional<E2eProtection> protection_;
  E2eState protection_state_;
};

}  // namespace odomd::can
