// The protocol from odomd to a recorder: messages over a stream, each a header and its bytes. Both
// ends must be the same build; the first message lets the recorder check this.
//
//   hello      a JSON object: the sender, and what a replay needs besides the files
//   file       a name, a zero byte, the contents; the configuration first, then its databases
//   buses      the names of the buses by index, each with a newline; again when there are more
//   state      the Checkpoint: PipelineState, then a ProtectionState per message
//   tick       a TickMark, its frames, its camera poses; the first tick is that of the checkpoint
//   end        text: why there are no more ticks
//   refused    text: why there is no recording
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/core/config.hpp"
#include "daemon/core/record.hpp"

namespace odomd::daemon {

class Pipeline;
struct Checkpoint;

enum class RecordingMessage : std::uint32_t { hello, file, buses, state, tick, end, refused };

struct RecordingHeader {
  RecordingMessage kind = RecordingMessage::hello;
  std::uint32_t size = 0;  ///< of the bytes that follow
};

/// The longest message: a tick of eight full buses, or a database.
inline constexpr std::uint32_t longest_recording_message = 1U << 26U;

/// A file of the message `file`: the configuration or a database, so that a recording can be used
/// on another machine.
struct RecordingFile {
  std::string name;  ///< in the folder, without any directory
  std::string text;
};

/// The configuration's text first, as "car.toml", with [can] dbc pointing to the copies; then the
/// databases under their own file names. Comments are kept. Throws std::runtime_error when a
/// database can no longer be read.
[[nodiscard]] std::vector<RecordingFile> recording_files(const Config& config);

/// Version, compiler and layout. Replays are bit-identical only if these are equal.
[[nodiscard]] std::string build_identity();

[[nodiscard]] inline std::string_view bytes_of(const auto& value) {
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

/// The bytes of a checkpoint, and back. The bytes contain the build and a checksum;
/// `restore_checkpoint` throws std::invalid_argument when they are incomplete or do not fit.
[[nodiscard]] std::string checkpoint_bytes(const Checkpoint& checkpoint);
void restore_checkpoint(std::string_view bytes, Pipeline& pipeline);

/// A 64-bit hash of the whole published record, without the fields that depend on the machine
/// (latency, execution time).
[[nodiscard]] std::uint64_t fingerprint(const TickRecord& record) noexcept;

}  // namespace odomd::daemon
