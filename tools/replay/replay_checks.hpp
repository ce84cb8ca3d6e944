// Reports of a successful replay: what may be wrong with its poses, and the result as JSON.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "can_protocol/decode/decoder.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/replay/virtual_drive.hpp"

namespace odomd::tools {

/// Why a mapped message gave no value; empty if it gave one.
[[nodiscard]] std::optional<diagnostics::Diagnostic> check_message(
    const can::BoundMessage& message, const can::MessageCounters& counters);

/// Reports a source if too many of its `judged` samples (gated or fused) were gated; `label` names
/// it. Nothing if fewer than ten were judged.
[[nodiscard]] std::optional<diagnostics::Diagnostic> check_gating(estimator::Source source,
                                                                  const std::string& label,
                                                                  std::uint64_t gated,
                                                                  std::uint64_t judged);

/// First reports each wiring fault that was found at any time (daemon/core/wiring.hpp), with its
/// sources but without its consequences, and a bias or scale that the filter did not learn or
/// learnt implausibly. Then reports, for each source: that it was inconsistent with the filter;
/// each flag that lasted a second or more (or a tenth of a shorter drive), except slips and
/// time-outs; that over a tenth of its samples was not used, or that it was silent for over a tenth
/// of the time; that over a tenth of its samples was gated.
[[nodiscard]] diagnostics::Diagnostics check_sources(const can::Decoder& decoder,
                                                     const ReplaySummary& summary);

/// Reports a mode that became fault: when, for how long, and the conditions that say why.
[[nodiscard]] std::optional<diagnostics::Diagnostic> check_mode(const ReplaySummary& summary);

/// Reports mapped messages without frames, without decoded frames or with frames cut off; frames
/// out of order; a camera outside the log; what check_sources() finds; a model that stopped; and,
/// last, a drive without a pose.
[[nodiscard]] diagnostics::Diagnostics check_replay(const can::Decoder& decoder,
                                                    const ReplaySummary& summary);

/// Counts, times, how the samples of each source were judged, and warnings. `seconds`: how long the
/// replay took.
[[nodiscard]] nlohmann::ordered_json replay_json(const ReplaySummary& summary, double seconds,
                                                 const diagnostics::Diagnostics& warnings);

/// The innovations per source, for sources with tested samples.
[[nodiscard]] nlohmann::ordered_json innovations_json(const ReplaySummary& summary);

/// The number of samples per source and verdict; zeros are left out.
[[nodiscard]] nlohmann::ordered_json verdicts_json(const ReplaySummary& summary);

}  // namespace odomd::tools
