// What may be wrong in a replay that succeeded: reported, so that nobody relies on wrong poses.
#pragma once

#include <optional>

#include "can_protocol/decode/decoder.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/replay/virtual_drive.hpp"

namespace odomd::tools {

/// Why a mapped message gave no value; nothing if it gave one.
[[nodiscard]] std::optional<diagnostics::Diagnostic> check_message(
    const can::BoundMessage& message, const can::MessageCounters& counters);

/// Mapped messages of which no frame came or none was decoded, frames out of order,
/// sensors that were rejected (source_checks.hpp), and, last, a drive without a pose.
[[nodiscard]] diagnostics::Diagnostics check_replay(const can::Decoder& decoder,
                                                    const ReplaySummary& summary);

}  // namespace odomd::tools
