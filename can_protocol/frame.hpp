// A CAN frame: one value type for SocketCAN, candump logs and standard input, classic CAN and CAN
// FD.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace odomd::can {

/// CAN FD's longest payload in bytes; classic frames use the first 8.
inline constexpr std::size_t max_payload = 64;

/// The maximum number of buses of one daemon.
inline constexpr std::size_t max_buses = 8;

enum class IdFormat : std::uint8_t { standard, extended };  // 11 bit, 29 bit
enum class FrameKind : std::uint8_t { data, remote, error };
enum class FrameProtocol : std::uint8_t { classic, fd };

struct Frame {
  std::int64_t time_ns = 0;  ///< time of reception on the clock of the source, see FrameSource
  std::uint32_t id = 0;      ///< identifier without flags; of an error frame: the error class bits
  IdFormat format = IdFormat::standard;
  FrameKind kind = FrameKind::data;
  FrameProtocol protocol = FrameProtocol::classic;
  std::uint8_t bus = 0;       ///< index of the bus, below max_buses
  std::uint8_t length = 0;    ///< payload bytes, 0 to max_payload
  std::uint8_t fd_flags = 0;  ///< CAN FD: bit 0 bit-rate switch, bit 1 error state indicator
  std::array<std::uint8_t, max_payload> data{};

  [[nodiscard]] std::span<const std::uint8_t> payload() const { return {data.data(), length}; }
};

/// The valid payload sizes of CAN FD.
[[nodiscard]] constexpr bool is_fd_length(std::size_t length) {
  return length <= 8 || length == 12 || length == 16 || length == 20 || length == 24 ||
         length == 32 || length == 48 || length == 64;
}

/// Masks of 29-bit identifiers: all bits, all but a J1939 priority, and the parameter group alone,
/// without priority, source address and, below PDU format 240 (PDU1), destination address.
inline constexpr std::uint32_t whole_id = 0x1FFF'FFFFU;
inline constexpr std::uint32_t id_without_priority = 0x03FF'FFFFU;
[[nodiscard]] constexpr std::uint32_t j1939_group_mask(std::uint32_t id) noexcept {
  return (id >> 16U & 0xFFU) < 240 ? 0x03FF'0000U : 0x03FF'FF00U;
}

/// In a key for receive filters, this bit selects all identifiers of the key's J1939 group.
inline constexpr std::uint32_t j1939_group_flag = 0x4000'0000U;

/// Identifier and format in one number, for comparing and looking up frames.
[[nodiscard]] constexpr std::uint32_t frame_key(std::uint32_t id, IdFormat format) {
  return id | (format == IdFormat::extended ? 0x8000'0000U : 0U);
}
[[nodiscard]] constexpr std::uint32_t frame_key(const Frame& frame) {
  return frame_key(frame.id, frame.format);
}

}  // namespace odomd::can
