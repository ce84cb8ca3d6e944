// Converts a line of a candump log (`candump -L`, `candump -l`) to a frame and back.
//
//   (1760000000.069964) can0 120#0400A0FF         classic, standard identifier: 3 digits
//   (1760000000.069964) can0 18DAF110#0210        extended identifier: 8 digits
//   (1760000000.069964) can0 123#R4               remote frame, length 4 (or 123#R)
//   (1760000000.069964) can0 20000004#0004000000000000   error frame: flag 20000000, class bits
//   (1760000000.069964) can0 123##1AABBCC         CAN FD: one digit of flags, then the payload
//   (1760000000.069964123) can0 123#1122334455667788_C R
//
// Also accepted: 9 decimals (nanoseconds), dots between bytes, the raw length code (`_9` to `_F`)
// of a classic frame of 8 bytes, the direction `R` or `T`, lower case digits, a carriage return.
// Stamps are handled as decimal integers, without rounding.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "can_protocol/frame.hpp"

namespace odomd::can {

/// An example line for messages about lines without a frame.
inline constexpr std::string_view candump_example = "(1760000000.069964) can0 120#0400A0FF";

/// The frame of a line, or its error.
struct CandumpLine {
  Frame frame;                 ///< `time_ns` on the log's clock; `bus` is left at 0
  std::string_view interface;  ///< points into the line
  std::string_view expected;   ///< what was expected at `column`; empty: the line is good
  std::size_t column = 0;      ///< 1-based

  [[nodiscard]] bool good() const noexcept { return expected.empty(); }
};

/// Parses one line, without its newline. Never throws or allocates. The raw length code and the
/// direction are checked and ignored.
[[nodiscard]] CandumpLine parse_candump_line(std::string_view line) noexcept;

enum class StampDecimals : std::uint8_t { six, nine };  // six: microseconds, truncated

/// Appends the line of a frame with its newline. `frame.time_ns` must not be negative.
void append_candump_line(std::string& out, const Frame& frame, std::string_view interface,
                         StampDecimals decimals = StampDecimals::six);

}  // namespace odomd::can
