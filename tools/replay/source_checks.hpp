// Sensors that a replay rejected: the daemon's warnings about them, given at the end.
#pragma once

#include <string_view>

#include "can_protocol/decode/decoder.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/replay/virtual_drive.hpp"

namespace odomd::tools {

/// For the fix of often_gated: "its unit, scale and sign, and the vehicle".
[[nodiscard]] std::string_view what_to_check(estimator::Source source);

/// First one diagnostic per fault of wiring or description found at any time
/// (daemon/core/wiring.hpp), with its sources; consequences of it are left out. Then one per source
/// that was inconsistent with the filter; that was flagged for a second or more (a tenth of a
/// shorter drive) as out of range, NaN or infinite, frozen, contradicting the others or failing its
/// protection; or of whose samples more than a tenth was gated, or not used for another reason; or
/// that was silent for a tenth of the time. For a camera in other units there is that one only.
[[nodiscard]] diagnostics::Diagnostics check_sources(const can::Decoder& decoder,
                                                     const ReplaySummary& summary);

}  // namespace odomd::tools
