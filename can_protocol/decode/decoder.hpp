// Decodes frames into signals: compiles the bindings of a configuration and the databases into one
// flat table. Compiling throws and allocates; decoding does neither.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/counter.hpp"
#include "can_protocol/dbc/dbc.hpp"
#include "can_protocol/decode/e2e.hpp"
#include "can_protocol/decode/signal_binding.hpp"
#include "can_protocol/frame.hpp"

namespace odomd::can {

/// One decoded quantity, in SI units.
struct Sample {
  std::uint16_t channel = 0;  ///< SignalBinding::channel
  std::int64_t time_ns = 0;   ///< frame time minus the binding's latency
  double value = 0.0;
};

/// The maximum number of samples of one frame.
inline constexpr std::size_t max_samples_per_frame = 24;

/// The result for a frame. Every frame has exactly one.
enum class FrameVerdict : std::uint8_t {
  decoded,         ///< at least one sample came out
  unmapped,        ///< no binding uses this id
  no_sample,       ///< bound, but its multiplexed signals are absent or all values invalid
  too_short,       ///< payload ends before a bound signal does
  failed_crc,      ///< protection: ERROR
  repeated,        ///< protection: REPEATED
  wrong_sequence,  ///< protection: WRONGSEQUENCE
  distrusted,      ///< protection: OK, but right after ERROR or after too many recent failures
  count
};

inline constexpr std::size_t frame_verdict_count = static_cast<std::size_t>(FrameVerdict::count);
inline constexpr std::array<std::string_view, frame_verdict_count> frame_verdict_names{
    "decoded",    "unmapped", "no_sample",      "too_short",
    "failed_crc", "repeated", "wrong_sequence", "distrusted"};

[[nodiscard]] constexpr std::string_view name_of(FrameVerdict verdict) noexcept {
  return frame_verdict_names[static_cast<std::size_t>(verdict)];
}

/// Counted per bound message; readable from any thread.
struct MessageCounters {
  Counter verdicts[frame_verdict_count];
  Counter some_lost;     ///< decoded frames with the protection state OKSOMELOST
  Counter last_time_ns;  ///< of the last decoded frame (bit pattern of the signed time)
};

struct DecodeResult {
  FrameVerdict verdict = FrameVerdict::unmapped;
  std::uint8_t count = 0;     ///< samples written
  std::int16_t message = -1;  ///< index into messages(), -1: unmapped
  /// Bit i: the value of the message's channel i is invalid, because of valid_when or unless_raw or
  /// because its source is still starting.
  std::uint32_t not_valid = 0;
};

/// A bound message, for status and for kernel filters.
struct BoundMessage {
  std::string name;
  std::uint32_t id = 0;
  IdFormat format = IdFormat::standard;
  std::int64_t cycle_time_ns = 0;  ///< GenMsgCycleTime; 0: none
  std::vector<std::uint16_t> channels;
  std::uint32_t id_mask = whole_id;  ///< see Message
};

/// State that protects against bad values of a message: the end-to-end state of each bus, and the
/// channels that have started.
struct ProtectionState {
  std::array<E2eState, max_buses> counters{};
  std::array<E2eTrust, max_buses> trust{};
  std::uint32_t started = 0;  ///< bit i: channel i has sent a value inside its raw range
  std::int64_t last_time_ns = 0;
};

class Decoder {
 public:
  struct Tables;  ///< the compiled form, decoder_tables.hpp

  /// Compiles the tables. Throws std::invalid_argument with a text that names the role, message or
  /// signal that does not fit, and the nearest valid name. `bus_names[i]` is the name of bus i in
  /// bindings.
  Decoder(std::span<const Database> databases, std::span<const SignalBinding> bindings,
          std::span<const E2eBinding> protections, std::span<const std::string> bus_names);
  ~Decoder();
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;
  Decoder(Decoder&&) noexcept;
  Decoder& operator=(Decoder&&) noexcept;

  /// Real-time safe; tens of nanoseconds. `samples` must hold max_samples_per_frame. A frame that
  /// fails its protection writes no sample.
  DecodeResult decode(const Frame& frame, std::span<Sample> samples) noexcept;

  /// Whether a binding uses frames of this identifier on this bus. Any thread.
  [[nodiscard]] bool is_mapped(const Frame& frame) const noexcept;

  [[nodiscard]] std::span<const BoundMessage> messages() const noexcept;
  [[nodiscard]] const MessageCounters& counters(std::size_t message) const noexcept;

  /// The state that decoding keeps between frames, one per message. The decoding thread may read
  /// it, and restore it in a decoder with the same bindings.
  [[nodiscard]] std::span<ProtectionState> protections() noexcept;
  [[nodiscard]] std::span<const ProtectionState> protections() const noexcept;

 private:
  std::unique_ptr<Tables> tables_;
};

}  // namespace odomd::can
