// What odomd sends to a recorder: messages over a stream, each a header and its bytes. Both ends
// are of one build; the first message lets the other end make sure of it.
//
//   hello      a JSON object: who sends, and what a replay has to know besides the files
//   file       a name, a zero byte, the contents; the configuration first, then its databases
//   buses      the names of the buses by index, each with a newline; again when there are more
//   state      the Checkpoint: PipelineState, then a ProtectionState a message
//   tick       a TickMark, its frames, its camera poses; the first is that of the checkpoint
//   end        text: why there are no more ticks
//   refused    text: why there is no recording
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "daemon/core/recording_tap.hpp"

namespace odomd::daemon {

enum class RecordingMessage : std::uint32_t { hello, file, buses, state, tick, end, refused };

struct RecordingHeader {
  RecordingMessage kind = RecordingMessage::hello;
  std::uint32_t size = 0;  ///< of the bytes that follow
};

/// No message is longer: a tick of eight full buses, a database.
inline constexpr std::uint32_t longest_recording_message = 1U << 26U;

/// What has to be alike where bits are to be: version, compiler, layout.
[[nodiscard]] std::string build_identity();

[[nodiscard]] inline std::string_view bytes_of(const auto& value) {
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

/// The bytes of a checkpoint, and back. The bytes say which build they are of and carry a checksum;
/// `restore_checkpoint` throws std::invalid_argument where they are not whole or do not fit.
[[nodiscard]] std::string checkpoint_bytes(const Checkpoint& checkpoint);
void restore_checkpoint(std::string_view bytes, Pipeline& pipeline);

/// A number that two records share only when all their bits are alike, but for one chance in 2^64:
/// of the whole published record, without what tells of the machine (latency, execution time).
[[nodiscard]] std::uint64_t fingerprint(const TickRecord& record) noexcept;

}  // namespace odomd::daemon
