// The decoder's compiled form: flat arrays that refer to one another by position. Internal to the
// decoder.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "can_protocol/dbc/signal_layout.hpp"
#include "can_protocol/decode/decoder.hpp"
#include "can_protocol/decode/e2e.hpp"

namespace odomd::can {

/// A range of one of the arrays.
struct Stretch {
  std::uint32_t first = 0;
  std::uint32_t count = 0;
};

/// A multiplexor that must have one of some raw values.
struct CompiledSelector {
  SignalLayout multiplexor;
  Stretch ranges;  ///< of Tables::ranges
};

/// A signal that must have one physical value. The raw bits are compared, so that rounding of scale
/// and offset does not matter.
struct CompiledMatch {
  SignalLayout signal;
  std::uint64_t bits = 0;
};

/// One binding: what to read from a payload, and how to convert it into a sample.
struct CompiledBinding {
  Stretch selectors;  ///< of Tables::selectors: all of them must hold
  Stretch terms;      ///< of Tables::terms: their physical values are summed
  std::optional<CompiledMatch> valid_when;
  std::optional<CompiledMatch> forward;  ///< if set, the sample is a direction
  std::optional<CompiledMatch> reverse;
  double unit_factor = 1.0;
  double scale = 1.0;
  double offset = 0.0;
  std::int64_t latency_ns = 0;
  std::uint16_t channel = 0;
  std::uint8_t bus_mask = 0;      ///< bit b: accepted from bus b
  std::uint8_t bytes_needed = 0;  ///< for its terms and conditions; selectors have their own
};

struct CompiledMessage {
  Stretch bindings;  ///< of Tables::bindings
  std::optional<E2eProtection> protection;
  std::uint8_t bus_mask = 0;  ///< of all its bindings
  std::int16_t next = -1;     ///< another message with this identifier, on other buses
};

struct ExtendedEntry {
  std::uint32_t id = 0;
  std::int16_t message = -1;
};

struct Decoder::Tables {
  Tables() { standard.fill(-1); }

  std::array<std::int16_t, 2048> standard{};  ///< by 11-bit identifier; -1: none
  std::vector<ExtendedEntry> extended;        ///< by 29-bit identifier, ascending
  std::vector<CompiledMessage> messages;
  std::vector<CompiledBinding> bindings;
  std::vector<CompiledSelector> selectors;
  std::vector<SignalLayout> terms;
  std::vector<MultiplexRange> ranges;

  std::vector<ProtectionState> protections;  ///< by message

  std::vector<BoundMessage> bound;        ///< by message
  std::vector<MessageCounters> counters;  ///< by message
};

/// The inputs of a compilation.
struct DecoderInputs {
  std::span<const Database> databases;
  std::span<const SignalBinding> bindings;
  std::span<const E2eBinding> protections;
  std::span<const std::string> bus_names;
};

/// Throws std::invalid_argument; see Decoder.
void compile(const DecoderInputs& inputs, Decoder::Tables& tables);

}  // namespace odomd::can
