// The decoder's compiled form: flat arrays that refer to one another by position. Internal to the
// decoder.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "can_protocol/dbc/signal_layout.hpp"
#include "can_protocol/decode/decoder.hpp"
#include "can_protocol/decode/e2e.hpp"

namespace odomd::can {

/// A range of elements in one of the arrays of Tables.
struct Stretch {
  std::uint32_t first = 0;
  std::uint32_t count = 0;
};

/// A multiplexor whose raw value must lie in one of the ranges.
struct CompiledSelector {
  SignalLayout multiplexor;
  Stretch ranges;  ///< of Tables::ranges
};

/// A signal and one of its physical values, as raw bits: rounding of scale and offset then does not
/// matter in comparisons.
struct CompiledMatch {
  SignalLayout signal;
  std::uint64_t bits = 0;
};

/// A condition of a valid value: the bits are equal or unequal to those of `match`, or the physical
/// value is below `limit` or at least `limit`.
struct CompiledCondition {
  CompiledMatch match;
  Comparison comparison = Comparison::equals;
  double limit = 0.0;
};

/// One binding: what to read from a payload, and how to convert it into a sample.
struct CompiledBinding {
  Stretch selectors;                      ///< of Tables::selectors: all of them must hold
  Stretch terms;                          ///< of Tables::terms: their physical values are summed
  Stretch conditions;                     ///< of Tables::conditions: all of them must hold
  std::optional<CompiledMatch> negative;  ///< if it matches, the sum's sign is changed
  std::optional<CompiledMatch> forward;   ///< if set, the sample is a direction
  std::optional<CompiledMatch> reverse;
  double unit_factor = 1.0;
  double scale = 1.0;
  double offset = 0.0;
  std::int64_t latency_ns = 0;
  std::uint16_t channel = 0;
  std::uint8_t bus_mask = 0;           ///< bit b: accepted from bus b
  std::uint8_t bytes_needed = 0;       ///< for its terms and conditions; selectors have their own
  std::optional<std::uint8_t> source;  ///< address of a J1939 sender
  bool doubts_first_ends = false;      ///< see starts_at_an_end()
};

struct CompiledMessage {
  Stretch bindings;  ///< of Tables::bindings
  std::optional<E2eProtection> protection;
  std::uint8_t bus_mask = 0;    ///< union over the bindings
  std::bitset<256> sources;     ///< J1939 senders (last bytes of identifiers) of all bindings
  std::int16_t next = -1;       ///< another message with this identifier, of other buses or sources
  std::int64_t restart_ns = 0;  ///< after a longer silence its sources start anew
};

struct ExtendedEntry {
  std::uint32_t id = 0;
  std::int16_t message = -1;
};

/// Messages in ascending order of the masked bits of their 29-bit identifiers.
struct MaskedEntries {
  std::uint32_t mask = whole_id;
  std::vector<ExtendedEntry> entries;
};

struct Decoder::Tables {
  Tables() { standard.fill(-1); }

  std::array<std::int16_t, 2048> standard{};  ///< message per 11-bit identifier; -1: none
  std::vector<MaskedEntries> extended;        ///< the strictest mask first; at most four
  std::vector<CompiledMessage> messages;
  std::vector<CompiledBinding> bindings;
  std::vector<CompiledSelector> selectors;
  std::vector<SignalLayout> terms;
  std::vector<CompiledCondition> conditions;
  std::vector<MultiplexRange> ranges;

  std::vector<ProtectionState> protections;  ///< one per message

  std::vector<BoundMessage> bound;        ///< one per message
  std::vector<MessageCounters> counters;  ///< one per message
};

/// The index of the message that accepts a data frame; -1: none.
[[nodiscard]] std::int16_t message_index(const Decoder::Tables& tables,
                                         const Frame& frame) noexcept;

/// Whether the binding accepts frames of this bus and sender.
[[nodiscard]] bool takes(const CompiledBinding& binding, const Frame& frame) noexcept;

enum class Outcome : std::uint8_t { value, absent, not_valid, too_short };

/// Sets `value` to the value of a binding in a frame of its message, if it is valid.
Outcome read_value(const Decoder::Tables& tables, const CompiledBinding& binding,
                   const Frame& frame, double& value) noexcept;

struct DecoderInputs {
  std::span<const Database> databases;
  std::span<const SignalBinding> bindings;
  std::span<const E2eBinding> protections;
  std::span<const std::string> bus_names;
};

/// Throws std::invalid_argument; see Decoder.
void compile(const DecoderInputs& inputs, Decoder::Tables& tables);

}  // namespace odomd::can
