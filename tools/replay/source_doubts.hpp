// Sensors that a replay did not believe: what the daemon says of them while it runs, said at the
// end.
#pragma once

#include <string>
#include <vector>

#include "can_protocol/decode/decoder.hpp"
#include "tools/replay/virtual_drive.hpp"

namespace odomd::tools {

/// First a line a mistake in the wiring or the description that was found at any time
/// (daemon/core/wiring.hpp), with the sources that it is of; of these nothing more that comes of
/// it. Then a line a source that did not fit what the filter expects; that was flagged for a second
/// or more (a tenth of a shorter drive) as out of range, no number, frozen, contradicting the
/// others or failing its protection; of whose samples more than a quarter was gated. Each says how
/// much, and what to look at. Of a camera in other units that alone.
[[nodiscard]] std::vector<std::string> source_doubts(const can::Decoder& decoder,
                                                     const ReplaySummary& summary);

}  // namespace odomd::tools
