#include "tools/fault/car_signals.hpp"

#include <algorithm>
#include <cmath>

#include "can_protocol/dbc/signal_layout.hpp"

namespace odomd::fault {
namespace {

using can::CompiledBinding;
using can::Decoder;
using can::SignalLayout;

bool is_direction(const CompiledBinding& binding) {
  return binding.forward || binding.reverse;
}

double physical_of(const SignalLayout& term, std::span<const std::uint8_t> payload) {
  return can::physical_value(term, can::extract_bits(term, payload));
}

std::span<const SignalLayout> terms_of(const Decoder::Tables& tables,
                                       const CompiledBinding& binding) {
  return std::span(tables.terms).subspan(binding.terms.first, binding.terms.count);
}

// The coarsest terms, such as the two wheels of an axle, share the change equally; the remainder
// goes to the finer ones, such as the decimals of an angle.
void write_sum(std::span<const SignalLayout> terms, double sum, std::span<std::uint8_t> payload) {
  double coarsest = 0.0;
  for (const SignalLayout& term : terms) coarsest = std::max(coarsest, std::abs(term.scale));
  const auto is_coarse = [&](const SignalLayout& term) {
    return std::abs(term.scale) > 0.999 * coarsest;
  };
  const auto coarse = std::ranges::count_if(terms, is_coarse);
  const bool all_coarse = coarse == std::ssize(terms);
  for (const SignalLayout& term : terms)
    if (!is_coarse(term)) can::insert_bits(term, can::bits_for(term, 0.0), payload);
  double change = sum;
  for (const SignalLayout& term : terms) change -= physical_of(term, payload);

  auto left = static_cast<double>(coarse);
  for (const bool now_coarse : {true, false})
    for (const SignalLayout& term : terms) {
      if (is_coarse(term) != now_coarse) continue;
      const double old = physical_of(term, payload);
      const double share = now_coarse ? change / left-- : change;
      // Rounded down if finer terms follow: those may be unsigned.
      const double down = now_coarse && !all_coarse ? 0.5 * coarsest : 0.0;
      can::insert_bits(term, can::bits_for(term, old + share - down), payload);
      change -= physical_of(term, payload) - old;
    }
}

}  // namespace

CarSignals::CarSignals(const daemon::CanConfig& config, std::span<const can::Database> databases,
                       std::span<const std::string> bus_names) {
  can::compile({databases, config.bindings, config.protections, bus_names}, tables_);
}

std::optional<std::size_t> CarSignals::message_of(const can::Frame& frame) const noexcept {
  const std::int16_t at = can::message_index(tables_, frame);
  return at < 0 ? std::nullopt : std::optional(static_cast<std::size_t>(at));
}

bool CarSignals::carries(std::size_t message, std::uint32_t sources) const noexcept {
  return std::ranges::any_of(tables_.bound[message].channels,
                             [&](std::uint16_t channel) { return (sources >> channel & 1U) != 0; });
}

std::size_t CarSignals::read(std::size_t message, const can::Frame& frame,
                             std::span<Reading> readings) const noexcept {
  const auto [first, count] = tables_.messages[message].bindings;
  std::size_t found = 0;
  for (std::uint32_t i = first; i < first + count && found < readings.size(); ++i) {
    const CompiledBinding& binding = tables_.bindings[i];
    double value = 0.0;
    if (!can::takes(binding, frame) ||
        can::read_value(tables_, binding, frame, value) != can::Outcome::value)
      continue;
    readings[found++] = {i, static_cast<estimator::Source>(binding.channel), value};
  }
  return found;
}

void CarSignals::write(std::uint32_t binding_index, double value,
                       can::Frame& frame) const noexcept {
  const CompiledBinding& binding = tables_.bindings[binding_index];
  const std::span payload(frame.data.data(), frame.length);
  const auto terms = terms_of(tables_, binding);
  if (std::isnan(value)) return;
  if (is_direction(binding)) {
    const auto& match = value > 0.0 ? binding.forward : binding.reverse;
    if (value != 0.0 && match) can::insert_bits(match->signal, match->bits, payload);
    if (value == 0.0) can::insert_bits(terms[0], 0, payload);
    return;
  }
  // value = scale · factor · Σ terms + offset
  double sum = (value - binding.offset) / (binding.scale * binding.unit_factor);
  if (const auto& negative = binding.negative) {
    can::insert_bits(negative->signal, sum < 0.0 ? negative->bits : negative->bits ^ 1U, payload);
    sum = std::abs(sum);
  }
  write_sum(terms, sum, payload);
}

void CarSignals::flip_bit(std::uint32_t binding_index, std::uint64_t draw,
                          can::Frame& frame) const noexcept {
  const std::span payload(frame.data.data(), frame.length);
  const auto terms = terms_of(tables_, tables_.bindings[binding_index]);
  const SignalLayout& term = terms[draw / 64 % terms.size()];
  const std::uint64_t bits = can::extract_bits(term, payload);
  can::insert_bits(term, bits ^ std::uint64_t{1} << draw % 64 % term.length, payload);
}

bool CarSignals::is_protected_right(std::size_t message, const can::Frame& frame,
                                    can::E2eState& counter) const noexcept {
  const auto& protection = tables_.messages[message].protection;
  if (!protection) return true;
  can::E2eState own;
  if (protection->check(frame.payload(), own) != can::E2eStatus::ok) return false;
  counter = own;
  return true;
}

void CarSignals::protect(std::size_t message, can::Frame& frame,
                         can::E2eState& counter) const noexcept {
  const auto& protection = tables_.messages[message].protection;
  if (protection && frame.length >= protection->length())
    protection->protect({frame.data.data(), frame.length}, counter);
}

// protect() gets the counter before the frame's own, or no counter if its own is 0.
void CarSignals::repair(std::size_t message, can::Frame& frame,
                        const can::E2eState& own) const noexcept {
  can::E2eState before;
  if (own.counter && *own.counter > 0) before.counter = *own.counter - 1;
  protect(message, frame, before);
}

}  // namespace odomd::fault
