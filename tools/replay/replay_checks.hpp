// Reports what may be wrong in a replay that succeeded, so that nobody relies on wrong poses.
#pragma once

#include <optional>
#include <string_view>

#include "can_protocol/decode/decoder.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/replay/virtual_drive.hpp"

namespace odomd::tools {

/// Why a mapped message gave no value; empty if it gave one.
[[nodiscard]] std::optional<diagnostics::Diagnostic> check_message(
    const can::BoundMessage& message, const can::MessageCounters& counters);

/// For the fix of often_gated: "its unit, scale and sign, and the vehicle".
[[nodiscard]] std::string_view what_to_check(estimator::Source source);

/// First one diagnostic per wiring fault found at any time (daemon/core/wiring.hpp), with its
/// sources but without its consequences, and those of a bias or scale not learnt plausibly. Then,
/// per source, one if it was inconsistent with the filter; one per flag that lasted a second or
/// more (a tenth of a shorter drive): out of range, NaN or infinite, frozen, contradicting the
/// others, failing its protection; one if over a tenth of its samples was not used, or it was
/// silent for over a tenth of the time; one if over a tenth was gated.
[[nodiscard]] diagnostics::Diagnostics check_sources(const can::Decoder& decoder,
                                                     const ReplaySummary& summary);

/// Reports mapped messages without frames, without decoded frames or with frames cut off; frames
/// out of order; a camera outside the log; sensors that were rejected; a model
/// that stopped; and, last, a drive without a pose.
[[nodiscard]] diagnostics::Diagnostics check_replay(const can::Decoder& decoder,
                                                    const ReplaySummary& summary);

}  // namespace odomd::tools
