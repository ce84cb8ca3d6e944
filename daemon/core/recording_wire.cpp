#include "daemon/core/recording_wire.hpp"

#include <algorithm>
#include <cstring>
#include <memory>
#include <stdexcept>

#include <fmt/format.h>

#include "daemon/core/pipeline.hpp"
#include "daemon/core/recording_tap.hpp"

namespace odomd::daemon {
namespace {

/// FNV-1a, 64 bits: xor a byte, multiply by the prime.
std::uint64_t hash(std::string_view bytes, std::uint64_t basis = 0xCBF2'9CE4'8422'2325) noexcept {
  std::uint64_t value = basis;
  for (const char byte : bytes)
    value = (value ^ static_cast<unsigned char>(byte)) * 0x0000'0100'0000'01B3;
  return value;
}

}  // namespace

std::string build_identity() {
  return fmt::format("odomd {}, {}, {} + {} + {} bytes", ODOMD_VERSION, __VERSION__,
                     sizeof(PipelineState), sizeof(can::ProtectionState), sizeof(TickMark));
}

std::string checkpoint_bytes(const Checkpoint& checkpoint) {
  std::string bytes = build_identity() + '\n';
  bytes += bytes_of(checkpoint.state);
  for (const auto& protection : checkpoint.protections) bytes += bytes_of(protection);
  bytes += bytes_of(hash(bytes));
  return bytes;
}

void restore_checkpoint(std::string_view bytes, Pipeline& pipeline) {
  const std::string ours = build_identity();
  const std::string identity = ours + '\n';
  if (!bytes.starts_with(identity))
    throw std::invalid_argument(
        fmt::format("is of another build ({}; this is {})",
                    bytes.substr(0, std::min<std::size_t>(bytes.find('\n'), 200)), ours));
  std::uint64_t sum = 0;
  const std::size_t protections = pipeline.protections().size();
  const std::size_t size = identity.size() + sizeof(PipelineState) +
                           protections * sizeof(can::ProtectionState) + sizeof sum;
  if (bytes.size() != size)
    throw std::invalid_argument(fmt::format("has {} bytes, not {}", bytes.size(), size));
  std::memcpy(&sum, bytes.data() + size - sizeof sum, sizeof sum);
  if (sum != hash(bytes.substr(0, size - sizeof sum)))
    throw std::invalid_argument("is damaged: its checksum is wrong");

  const auto checkpoint = std::make_unique<Checkpoint>(
      pipeline.state(), std::vector<can::ProtectionState>(protections));
  const char* at = bytes.data() + identity.size();
  // Neither type owns anything: the bytes are the complete objects.
  std::memcpy(static_cast<void*>(&checkpoint->state), at, sizeof checkpoint->state);
  std::memcpy(checkpoint->protections.data(), at + sizeof checkpoint->state,
              protections * sizeof(can::ProtectionState));
  pipeline.restore(checkpoint->state, checkpoint->protections);
}

std::uint64_t fingerprint(const TickRecord& record) noexcept {
  static_assert(sizeof(odom_pose) % 8 == 0 && sizeof(odom_details) % 8 == 0);  // no padding
  return hash(bytes_of(record.details), hash(bytes_of(record.pose)));
}

}  // namespace odomd::daemon
