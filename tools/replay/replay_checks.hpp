// Reports what may be wrong in a replay that succeeded, so that nobody relies on wrong poses.
#pragma once

#include <optional>

#include "can_protocol/decode/decoder.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/replay/virtual_drive.hpp"

namespace odomd::tools {

/// Why a mapped message gave no value; empty if it gave one.
[[nodiscard]] std::optional<diagnostics::Diagnostic> check_message(
    const can::BoundMessage& message, const can::MessageCounters& counters);

/// Reports mapped messages without frames, without decoded frames or with frames cut off; frames
/// out of order; a camera outside the log; sensors that were rejected (source_checks.hpp); a model
/// that stopped; and, last, a drive without a pose.
[[nodiscard]] diagnostics::Diagnostics check_replay(const can::Decoder& decoder,
                                                    const ReplaySummary& summary);

}  // namespace odomd::tools
