// What may be wrong in a replay that succeeded: reported, so that nobody relies on wrong poses.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "can_protocol/decode/decoder.hpp"
#include "tools/replay/virtual_drive.hpp"

namespace odomd::tools {

/// Why a mapped message gave no value, "message 'IMU' (yaw_rate): no frame of it is in the log;
/// ..."; nothing if it gave one.
[[nodiscard]] std::optional<std::string> message_warning(const can::BoundMessage& message,
                                                         const can::MessageCounters& counters);

/// One line each: mapped messages of which no frame came or none was decoded, frames out of order,
/// sensors that were rejected (source_checks.hpp), and, last, a drive without a pose.
[[nodiscard]] std::vector<std::string> replay_warnings(const can::Decoder& decoder,
                                                       const ReplaySummary& summary);

}  // namespace odomd::tools
