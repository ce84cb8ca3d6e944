// Converts physical values to bits, and tests whether multiplexed signals are present.
#include "can_protocol/dbc/signal_layout.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace odomd::can {

std::uint64_t bits_for(const SignalLayout& signal, double physical) noexcept {
  const double raw = (physical - signal.offset) / signal.scale;
  switch (signal.type) {
    case ValueType::float32: {
      constexpr double largest = std::numeric_limits<float>::max();
      const double held = std::isfinite(raw) ? std::clamp(raw, -largest, largest) : raw;
      return std::bit_cast<std::uint32_t>(static_cast<float>(held));
    }
    case ValueType::float64:
      return std::bit_cast<std::uint64_t>(raw);
    case ValueType::unsigned_integer: {
      const std::uint64_t largest = low_bits(signal.length);
      const double rounded = std::round(raw);
      if (!(rounded > 0.0)) return 0;
      // The comparison is exact: below 2^53 both are integers, above it the cast rounds up to 2^n.
      return rounded >= static_cast<double>(largest) ? largest
                                                     : static_cast<std::uint64_t>(rounded);
    }
    case ValueType::signed_integer: {
      const std::uint64_t largest = low_bits(signal.length) >> 1U;
      const std::uint64_t smallest = largest + 1;  // the bits of the most negative value
      const double rounded = std::round(raw);
      if (std::isnan(rounded)) return 0;
      if (rounded >= static_cast<double>(largest)) return largest;
      if (rounded <= -static_cast<double>(smallest)) return smallest;
      return static_cast<std::uint64_t>(static_cast<std::int64_t>(rounded)) &
             low_bits(signal.length);
    }
  }
  return 0;
}

bool is_present(const Message& message, const Signal& signal,
                std::span<const std::uint8_t> payload) noexcept {
  for (const Signal* at = &signal; at->multiplexor; at = &message.signals[*at->multiplexor]) {
    const SignalLayout multiplexor = layout_of(message.signals[*at->multiplexor]);
    if (payload.size() < multiplexor.bytes_needed) return false;
    const std::uint64_t selected = extract_bits(multiplexor, payload);
    if (std::none_of(at->selected_by.begin(), at->selected_by.end(), [&](const auto& range) {
          return range.first <= selected && selected <= range.last;
        }))
      return false;
  }
  return true;
}

}  // namespace odomd::can
