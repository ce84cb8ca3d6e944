// The bridge itself: follows the segment, and hands what is due to the sinks.
#pragma once

#include <memory>
#include <vector>

#include "tools/bridge/options.hpp"
#include "tools/bridge/sample.hpp"

namespace odomd::tools {

/// Sends until INT, TERM, or the end of the duration, and says what was sent. It waits for a daemon
/// that is not there, and goes on with its successor. A reader of the segment like any other: it
/// cannot hold the daemon up. Throws std::invalid_argument for a name that is no segment's,
/// std::runtime_error where the segment is refused, or the duration passed without a daemon.
void run_bridge(const BridgeOptions& options, const std::vector<std::unique_ptr<Sink>>& sinks);

}  // namespace odomd::tools
