// Decodes frames with the compiled tables. Nothing here allocates, locks or throws except the
// constructor.
#include "can_protocol/decode/decoder.hpp"

#include <algorithm>

#include "can_protocol/decode/decoder_tables.hpp"

namespace odomd::can {
namespace {

/// All bytes of a frame, so that a signal can be read from eight bytes at once. Bytes after
/// `length` are never part of a signal.
struct Payload {
  std::span<const std::uint8_t, max_payload> bytes;
  std::size_t length;
};

std::int16_t message_index(const Decoder::Tables& tables, const Frame& frame) noexcept {
  if (frame.format == IdFormat::standard)
    return frame.id < tables.standard.size() ? tables.standard[frame.id] : std::int16_t{-1};
  const auto found =
      std::lower_bound(tables.extended.begin(), tables.extended.end(), frame.id,
                       [](const ExtendedEntry& entry, std::uint32_t id) { return entry.id < id; });
  return found != tables.extended.end() && found->id == frame.id ? found->message
                                                                 : std::int16_t{-1};
}

bool matches(const CompiledMatch& match, std::uint64_t bits) noexcept {
  const ValueType type = match.signal.type;
  if (type == ValueType::float32 || type == ValueType::float64)  // 0 and -0 are the same value
    return physical_value(match.signal, bits) == physical_value(match.signal, match.bits);
  return bits == match.bits;
}

enum class Outcome : std::uint8_t { value, absent, too_short };

/// Whether the multiplexors in the payload select the binding.
Outcome selected(const Decoder::Tables& tables, const CompiledBinding& binding,
                 Payload payload) noexcept {
  for (std::uint32_t i = 0; i < binding.selectors.count; ++i) {
    const CompiledSelector& selector = tables.selectors[binding.selectors.first + i];
    if (payload.length < selector.multiplexor.bytes_needed) return Outcome::too_short;
    const std::uint64_t raw = extract_bits(selector.multiplexor, payload.bytes);
    const auto* range = tables.ranges.data() + selector.ranges.first;
    if (std::none_of(range, range + selector.ranges.count,
                     [raw](const MultiplexRange& r) { return r.first <= raw && raw <= r.last; }))
      return Outcome::absent;
  }
  return Outcome::value;
}

/// quantity = scale * (unit_factor * sum of physical values) + offset, or a direction.
Outcome evaluate(const Decoder::Tables& tables, const CompiledBinding& binding, Payload payload,
                 double& value) noexcept {
  const Outcome selection = selected(tables, binding, payload);
  if (selection != Outcome::value) return selection;
  if (payload.length < binding.bytes_needed) return Outcome::too_short;
  if (binding.valid_when &&
      !matches(*binding.valid_when, extract_bits(binding.valid_when->signal, payload.bytes)))
    return Outcome::absent;
  const auto* terms = tables.terms.data() + binding.terms.first;
  if (binding.forward || binding.reverse) {
    const std::uint64_t bits = extract_bits(terms[0], payload.bytes);
    const bool forward = binding.forward && matches(*binding.forward, bits);
    const bool reverse = binding.reverse && matches(*binding.reverse, bits);
    value = forward ? 1.0 : reverse ? -1.0 : 0.0;
    return Outcome::value;
  }
  double sum = 0.0;
  for (std::uint32_t i = 0; i < binding.terms.count; ++i)
    sum += physical_value(terms[i], extract_bits(terms[i], payload.bytes));
  value = binding.scale * (binding.unit_factor * sum) + binding.offset;
  return Outcome::value;
}

DecodeResult decode_signals(const Decoder::Tables& tables, const CompiledMessage& message,
                            const Frame& frame, Payload payload,
                            std::span<Sample> samples) noexcept {
  const unsigned bus_bit = 1U << frame.bus;
  std::uint8_t count = 0;
  const std::span bindings(tables.bindings);
  for (const auto& binding : bindings.subspan(message.bindings.first, message.bindings.count)) {
    if ((binding.bus_mask & bus_bit) == 0) continue;
    double value = 0.0;
    const Outcome outcome = evaluate(tables, binding, payload, value);
    if (outcome == Outcome::too_short) return {FrameVerdict::too_short, 0};
    if (outcome == Outcome::value && count < samples.size())
      samples[count++] = {binding.channel, frame.time_ns - binding.latency_ns, value};
  }
  return {count > 0 ? FrameVerdict::decoded : FrameVerdict::no_sample, count};
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
  const Payload payload{frame.data, std::min<std::size_t>(frame.length, max_payload)};
  E2eStatus status = E2eStatus::ok;
  if (message.protection) {
    if (payload.length < message.protection->length()) return {FrameVerdict::too_short, 0};
    status =
        message.protection->check(payload.bytes.first(payload.length), state.counters[frame.bus]);
    const bool trusted = state.trust[frame.bus].after(status);
    if (const FrameVerdict verdict = verdict_of(status); verdict != FrameVerdict::decoded)
      return {verdict, 0};
    if (!trusted) return {FrameVerdict::distrusted, 0};
  }
  const DecodeResult result = decode_signals(tables, message, frame, payload, samples);
  if (result.verdict == FrameVerdict::decoded) {
    if (status == E2eStatus::ok_some_lost) counters.some_lost.add();
    counters.last_time_ns.set(static_cast<std::uint64_t>(frame.time_ns));
  }
  return result;
}

}  // namespace

Decoder::Decoder(std::span<const Database> databases, std::span<const SignalBinding> bindings,
                 std::span<const E2eBinding> protections, std::span<const std::string> bus_names)
    : tables_(std::make_unique<Tables>()) {
  compile({databases, bindings, protections, bus_names}, *tables_);
}

Decoder::~Decoder() = default;
Decoder::Decoder(Decoder&&) noexcept = default;
Decoder& Decoder::operator=(Decoder&&) noexcept = default;

DecodeResult Decoder::decode(const Frame& frame, std::span<Sample> samples) noexcept {
  if (frame.kind != FrameKind::data || frame.bus >= max_buses) return {};
  const unsigned bus_bit = 1U << frame.bus;
  for (std::int16_t at = message_index(*tables_, frame); at >= 0;) {
    const auto index = static_cast<std::size_t>(at);
    const CompiledMessage& message = tables_->messages[index];
    if ((message.bus_mask & bus_bit) != 0) {
      MessageCounters& counters = tables_->counters[index];
      DecodeResult result =
          decode_message(*tables_, message, tables_->protections[index], counters, frame, samples);
      result.message = at;
      counters.verdicts[static_cast<std::size_t>(result.verdict)].add();
      return result;
    }
    at = message.next;
  }
  return {};
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
