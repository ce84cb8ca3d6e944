// Converts physical values to bits, and tests whether multiplexed signals are present.
#include "can_protocol/dbc/signal_layout.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <string_view>

namespace odomd::can {
namespace {

/// Room for a number below `largest_written` in fixed notation with up to `most_decimals` decimals.
using Text = std::array<char, 64>;
constexpr double largest_written = 1e15;
constexpr int most_decimals = 20;

/// The decimals of the shortest notation: 4 for 0.0005, 0 for 20.
int decimals_of(double value) {
  Text text{};
  const auto written =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::scientific);
  const std::string_view digits(text.data(), written.ptr);  // d.ddde-xx
  const std::size_t e = digits.find('e');
  const std::size_t point = digits.find('.');
  if (e == std::string_view::npos) return 0;  // not finite
  const char* const sign = digits.data() + e + 1;
  int exponent = 0;
  std::from_chars(*sign == '+' ? sign + 1 : sign, written.ptr, exponent);
  const int behind_the_point =
      point == std::string_view::npos ? 0 : static_cast<int>(e - point) - 1;
  return std::max(0, behind_the_point - exponent);
}

double read_back(const Text& text, const char* end, double otherwise) {
  double value = otherwise;
  std::from_chars(text.data(), end, value);
  return value;
}

}  // namespace

double as_written(const SignalLayout& signal, double physical) noexcept {
  Text text{};
  char* const end = text.data() + text.size();
  if (signal.type == ValueType::float64 || !(std::abs(physical) < largest_written)) return physical;
  if (signal.type == ValueType::float32)
    return read_back(text, std::to_chars(text.data(), end, static_cast<float>(physical)).ptr,
                     physical);
  const int decimals = std::max(decimals_of(signal.scale), decimals_of(signal.offset));
  if (decimals > most_decimals) return physical;
  const auto written =
      std::to_chars(text.data(), end, physical, std::chars_format::fixed, decimals);
  return read_back(text, written.ptr, physical);
}

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
    if (!is_selected(at->selected_by, extract_bits(multiplexor, payload))) return false;
  }
  return true;
}

}  // namespace odomd::can
