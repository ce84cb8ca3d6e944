// What a replay that went through may still have got wrong: said, so that no wrong pose is
// believed.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "can_protocol/decode/decoder.hpp"
#include "tools/replay/virtual_drive.hpp"

namespace odomd::tools {

/// Why a mapped message gave no value, "message 'IMU' (yaw_rate): no frame of it is in the log;
/// ..."; nothing where it gave one.
[[nodiscard]] std::optional<std::string> message_doubt(const can::BoundMessage& message,
                                                       const can::MessageCounters& counters);

/// One line each: mapped messages of which no frame came or none was decoded, frames out of order,
/// sensors that were not believed (source_doubts.hpp), and, last, a drive without a pose.
[[nodiscard]] std::vector<std::string> replay_doubts(const can::Decoder& decoder,
                                                     const ReplaySummary& summary);

}  // namespace odomd::tools
