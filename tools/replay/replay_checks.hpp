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

/// Mapped messages of which no frame came, none was decoded or some are cut off; frames out of
/// order; a camera outside the log; sensors that were rejected (source_checks.hpp); a model that
/// stopped; and, last, a drive without a pose.
[[nodiscard]] diagnostics::Diagnostics check_replay(const can::Decoder& decoder,
                                                    const ReplaySummary& summary);

}  // namespace odomd::tools
