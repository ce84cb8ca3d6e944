// Converts the physical and raw values of conditions to bits.
#include "can_protocol/decode/condition_compile.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <stdexcept>

namespace odomd::can {
namespace {

/// Shortest decimal form, for messages.
std::string show(double value) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

double tolerance(const Signal& signal, double value) {
  return 1e-6 * std::abs(signal.scale) + 1e-12 * std::abs(value);
}

}  // namespace

void refuse(const SignalBinding& binding, const std::string& text) {
  throw std::invalid_argument("signal '" + binding.role + "': " + text);
}

CompiledMatch compile_match(const SignalBinding& binding, const Signal& signal, double value) {
  const SignalLayout layout = layout_of(signal);
  const std::uint64_t bits = bits_for(layout, value);
  const double nearest = physical_value(layout, bits);
  if (!(std::abs(nearest - value) <= tolerance(signal, value)))
    refuse(binding, "signal '" + signal.name + "' never has the value " + show(value) +
                        "; the nearest is " + show(as_written(layout, nearest)));
  return {layout, bits};
}

CompiledCondition compile_condition(const SignalBinding& binding, const Signal& signal,
                                    const ValidWhen& condition) {
  if (condition.comparison == Comparison::equals || condition.comparison == Comparison::not_equals)
    return {compile_match(binding, signal, condition.value), condition.comparison, 0.0};
  // The tolerance keeps rounding from moving a value equal to the limit below the limit.
  return {{layout_of(signal), 0},
          condition.comparison,
          condition.value - tolerance(signal, condition.value)};
}

void add_unless_raw(const SignalBinding& binding, const Signal& signal,
                    std::vector<CompiledCondition>& conditions) {
  if (!binding.unless_raw) return;
  const bool is_signed = signal.type == ValueType::signed_integer;
  if (!is_signed && signal.type != ValueType::unsigned_integer)
    refuse(binding,
           "signal '" + signal.name + "' is a floating-point number; unless_raw is for integers");
  const std::uint64_t ones = low_bits(signal.length);
  const auto add = [&](std::uint64_t bits) {
    conditions.push_back({{layout_of(signal), bits}, Comparison::not_equals, 0.0});
  };
  if (binding.unless_raw->pattern == UnlessRaw::Pattern::all_ones) add(ones);
  if (binding.unless_raw->pattern == UnlessRaw::Pattern::max) add(is_signed ? ones >> 1U : ones);
  for (const std::int64_t value : binding.unless_raw->values) {
    const std::uint64_t bits = static_cast<std::uint64_t>(value) & ones;
    const std::int64_t back =
        is_signed ? sign_extended(bits, signal.length) : static_cast<std::int64_t>(bits);
    if (back != value)
      refuse(binding, "signal '" + signal.name + "' never has the raw value " +
                          std::to_string(value) + "; fix unless_raw");
    add(bits);
  }
}

}  // namespace odomd::can
