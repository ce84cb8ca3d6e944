// Sensors that a replay did not believe: what the daemon says of them while it runs, said at the
// end.
#pragma once

#include <string>
#include <vector>

#include "can_protocol/decoder.hpp"
#include "tools/virtual_drive.hpp"

namespace odomd::tools {

/// A line a source that was flagged for a second or more (a tenth of a shorter drive) as out of
/// range, no number, frozen, contradicting the others or failing its protection; and one a source
/// of whose samples more than a quarter was gated; one that was found wired or described wrongly
/// (daemon/wiring.hpp), or scattering far too much, at any time. Each says how much, and what to
/// look at. Of a camera in other units that alone.
[[nodiscard]] std::vector<std::string> source_doubts(const can::Decoder& decoder,
                                                     const ReplaySummary& summary);

}  // namespace odomd::tools
