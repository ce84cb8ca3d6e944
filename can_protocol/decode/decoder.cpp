// Decodes frames with the compiled tables. Nothing here allocates, locks or throws except the
// constructor.
#include "can_protocol/decode/decoder.hpp"

#include <algorithm>

#include "can_protocol/decode/decoder_tables.hpp"

namespace odomd::can {
namespace {

std::size_t length_of(const Frame& frame) noexcept {
  return std::min<std::size_t>(frame.length, max_payload);
}

std::uint8_t source_of(const Frame& frame) noexcept {
  return static_cast<std::uint8_t>(frame.id & 0xFFU);
}

/// The first message in the chain that accepts the bus and the sender of the frame.
std::int16_t first_taker(const Decoder::Tables& tables, std::int16_t at,
                         const Frame& frame) noexcept {
  for (; at >= 0; at = tables.messages[static_cast<std::size_t>(at)].next) {
    const CompiledMessage& message = tables.messages[static_cast<std::size_t>(at)];
    if ((message.bus_mask & 1U << frame.bus) != 0 && message.sources[source_of(frame)]) return at;
  }
  return -1;
}

bool matches(const CompiledMatch& match, const Frame& frame) noexcept {
  const std::uint64_t bits = extract_bits(match.signal, frame.data);
  const ValueType type = match.signal.type;
  if (type == ValueType::float32 || type == ValueType::float64)  // 0 and -0 are the same value
    return physical_value(match.signal, bits) == physical_value(match.signal, match.bits);
  return bits == match.bits;
}

bool holds(const CompiledCondition& condition, const Frame& frame) noexcept {
  const SignalLayout& signal = condition.match.signal;
  switch (condition.comparison) {
    case Comparison::equals:
      return matches(condition.match, frame);
    case Comparison::not_equals:
      return !matches(condition.match, frame);
    case Comparison::below:
      return physical_value(signal, extract_bits(signal, frame.data)) < condition.limit;
    case Comparison::at_least:
      return physical_value(signal, extract_bits(signal, frame.data)) >= condition.limit;
  }
  return false;
}

/// Whether the multiplexors in the payload select the binding.
Outcome selected(const Decoder::Tables& tables, const CompiledBinding& binding,
                 const Frame& frame) noexcept {
  for (std::uint32_t i = 0; i < binding.selectors.count; ++i) {
    const CompiledSelector& selector = tables.selectors[binding.selectors.first + i];
    if (length_of(frame) < selector.multiplexor.bytes_needed) return Outcome::too_short;
    if (!is_selected({tables.ranges.data() + selector.ranges.first, selector.ranges.count},
                     extract_bits(selector.multiplexor, frame.data)))
      return Outcome::absent;
  }
  return Outcome::value;
}

/// Whether the raw value is all ones (unsigned) or either end of the range (signed). Control units
/// send such values until the sensor has measured. No real value is at an end when a car starts, so
/// they are rejected until another comes. Signals of under 8 bits may be at an end.
bool is_at_an_end(const SignalLayout& signal, const Frame& frame) noexcept {
  constexpr unsigned shortest_measurement = 8;  // bits
  if (signal.length < shortest_measurement) return false;
  const std::uint64_t bits = extract_bits(signal, frame.data);
  const std::uint64_t largest = low_bits(signal.length);
  if (signal.type == ValueType::unsigned_integer) return bits == largest;
  return signal.type == ValueType::signed_integer &&
         (bits == largest >> 1U || bits == (largest >> 1U) + 1);
}

bool starts_at_an_end(const Decoder::Tables& tables, const CompiledBinding& binding,
                      const Frame& frame) noexcept {
  const auto* terms = tables.terms.data() + binding.terms.first;
  return binding.doubts_first_ends &&
         std::any_of(terms, terms + binding.terms.count,
                     [&](const SignalLayout& term) { return is_at_an_end(term, frame); });
}

DecodeResult decode_signals(const Decoder::Tables& tables, const CompiledMessage& message,
                            const Frame& frame, ProtectionState& state,
                            std::span<Sample> samples) noexcept {
  if (frame.time_ns - state.last_time_ns > message.restart_ns) state.started = 0;
  state.last_time_ns = frame.time_ns;
  DecodeResult result;
  for (std::uint32_t i = 0; i < message.bindings.count; ++i) {
    const CompiledBinding& binding = tables.bindings[message.bindings.first + i];
    if (!takes(binding, frame)) continue;
    double value = 0.0;
    Outcome outcome = read_value(tables, binding, frame, value);
    if (outcome == Outcome::too_short) return {FrameVerdict::too_short, 0};
    if (outcome == Outcome::value && (state.started & 1U << i) == 0) {
      if (starts_at_an_end(tables, binding, frame))
        outcome = Outcome::not_valid;
      else
        state.started |= 1U << i;
    }
    if (outcome == Outcome::not_valid) result.not_valid |= 1U << i;
    if (outcome == Outcome::value && result.count < samples.size())
      samples[result.count++] = {binding.channel, frame.time_ns - binding.latency_ns, value};
  }
  result.verdict = result.count > 0 ? FrameVerdict::decoded : FrameVerdict::no_sample;
  return result;
}

FrameVerdict verdict_of(E2eStatus status) noexcept {
  switch (status) {
    case E2eStatus::ok:
    case E2eStatus::ok_some_lost:
      return FrameVerdict::decoded;
    case E2eStatus::repeated:
      return FrameVerdict::repeated;
    case E2eStatus::wrong_sequence:
      return FrameVerdict::wrong_sequence;
    case E2eStatus::error:
      return FrameVerdict::failed_crc;
    case E2eStatus::no_new_data:
      return FrameVerdict::too_short;
  }
  return FrameVerdict::failed_crc;
}

DecodeResult decode_message(const Decoder::Tables& tables, const CompiledMessage& message,
                            ProtectionState& state, MessageCounters& counters, const Frame& frame,
                            std::span<Sample> samples) noexcept {
  E2eStatus status = E2eStatus::ok;
  if (message.protection) {
    const auto payload = std::span(frame.data).first(length_of(frame));
    if (payload.size() < message.protection->length()) return {FrameVerdict::too_short, 0};
    status = message.protection->check(payload, state.counters[frame.bus]);
    const bool trusted = state.trust[frame.bus].after(status);
    if (const FrameVerdict verdict = verdict_of(status); verdict != FrameVerdict::decoded)
      return {verdict, 0};
    if (!trusted) return {FrameVerdict::distrusted, 0};
  }
  const DecodeResult result = decode_signals(tables, message, frame, state, samples);
  if (result.verdict == FrameVerdict::decoded) {
    if (status == E2eStatus::ok_some_lost) counters.some_lost.add();
    counters.last_time_ns.set(static_cast<std::uint64_t>(frame.time_ns));
  }
  return result;
}

}  // namespace

std::int16_t message_index(const Decoder::Tables& tables, const Frame& frame) noexcept {
  if (frame.kind != FrameKind::data || frame.bus >= max_buses) return -1;
  if (frame.format == IdFormat::standard)
    return frame.id < tables.standard.size() ? first_taker(tables, tables.standard[frame.id], frame)
                                             : std::int16_t{-1};
  if (frame.id > whole_id) return -1;
  for (const auto& [mask, entries] : tables.extended) {
    const std::uint32_t id = frame.id & mask;
    const auto found =
        std::lower_bound(entries.begin(), entries.end(), id,
                         [](const ExtendedEntry& a, std::uint32_t b) { return a.id < b; });
    if (found == entries.end() || found->id != id) continue;
    if (const std::int16_t at = first_taker(tables, found->message, frame); at >= 0) return at;
  }
  return -1;
}

bool takes(const CompiledBinding& binding, const Frame& frame) noexcept {
  return (binding.bus_mask & 1U << frame.bus) != 0 &&
         (!binding.source || *binding.source == source_of(frame));
}

/// quantity = scale * (unit_factor * sum of physical values) + offset, or a direction.
Outcome read_value(const Decoder::Tables& tables, const CompiledBinding& binding,
                   const Frame& frame, double& value) noexcept {
  const Outcome selection = selected(tables, binding, frame);
  if (selection != Outcome::value) return selection;
  if (length_of(frame) < binding.bytes_needed) return Outcome::too_short;
  for (std::uint32_t i = 0; i < binding.conditions.count; ++i)
    if (!holds(tables.conditions[binding.conditions.first + i], frame)) return Outcome::not_valid;
  if (binding.forward || binding.reverse) {
    const bool forward = binding.forward && matches(*binding.forward, frame);
    const bool reverse = binding.reverse && matches(*binding.reverse, frame);
    value = forward ? 1.0 : reverse ? -1.0 : 0.0;
    return Outcome::value;
  }
  const auto* terms = tables.terms.data() + binding.terms.first;
  double sum = 0.0;
  for (std::uint32_t i = 0; i < binding.terms.count; ++i)
    sum += physical_value(terms[i], extract_bits(terms[i], frame.data));
  if (binding.negative && matches(*binding.negative, frame)) sum = -sum;
  value = binding.scale * (binding.unit_factor * sum) + binding.offset;
  return Outcome::value;
}

Decoder::Decoder(std::span<const Database> databases, std::span<const SignalBinding> bindings,
                 std::span<const E2eBinding> protections, std::span<const std::string> bus_names)
    : tables_(std::make_unique<Tables>()) {
  compile({databases, bindings, protections, bus_names}, *tables_);
}

Decoder::~Decoder() = default;
Decoder::Decoder(Decoder&&) noexcept = default;
Decoder& Decoder::operator=(Decoder&&) noexcept = default;

DecodeResult Decoder::decode(const Frame& frame, std::span<Sample> samples) noexcept {
  const std::int16_t at = message_index(*tables_, frame);
  if (at < 0) return {};
  const auto index = static_cast<std::size_t>(at);
  MessageCounters& counters = tables_->counters[index];
  DecodeResult result = decode_message(*tables_, tables_->messages[index],
                                       tables_->protections[index], counters, frame, samples);
  result.message = at;
  counters.verdicts[static_cast<std::size_t>(result.verdict)].add();
  return result;
}

bool Decoder::is_mapped(const Frame& frame) const noexcept {
  return message_index(*tables_, frame) >= 0;
}

std::span<const BoundMessage> Decoder::messages() const noexcept {
  return tables_->bound;
}

const MessageCounters& Decoder::counters(std::size_t message) const noexcept {
  return tables_->counters[message];
}

std::span<ProtectionState> Decoder::protections() noexcept {
  return tables_->protections;
}

std::span<const ProtectionState> Decoder::protections() const noexcept {
  return tables_->protections;
}

}  // namespace odomd::can
