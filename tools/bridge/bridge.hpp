// The bridge itself: follows the segment, and hands what is due to the sinks.
#pragma once

#include <memory>
#include <vector>

#include "tools/bridge/options.hpp"
#include "tools/bridge/sample.hpp"

namespace odomd::tools {

/// Sends until INT, TERM or the end of the duration, then prints a summary. On a terminal it shows
/// the newest pose and the counts once a second, unless the summary is JSON. Waits if there is no
/// daemon, and reconnects when it restarts. It only reads the segment, so it cannot delay the
/// daemon. Throws std::invalid_argument for an invalid segment name, std::runtime_error if the
/// segment is refused or the duration passed without a daemon.
void run_bridge(const BridgeOptions& options, const std::vector<std::unique_ptr<Sink>>& sinks);

}  // namespace odomd::tools
