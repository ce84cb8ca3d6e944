// The options by which a command finds the daemon, in the same words everywhere.
#pragma once

#include <string>

#include "tools/cli/command.hpp"

namespace odomd::tools {

/// What stands for a segment that is not named: the library's defaults; or, for commands that have
/// --socket too and where that is given, the segment of the daemon behind it.
enum class SegmentElse { default_names, of_socket };

/// --shm: the segment that the daemon publishes in.
Option add_segment_option(Command command, std::string& name,
                          SegmentElse otherwise = SegmentElse::default_names);

/// --socket. `door` is what the daemon listens for there: "status", "record", "camera".
Option add_socket_option(Command command, std::string& path, const std::string& door);

/// --wait [s].
Option add_wait_option(Command command, double& seconds);

}  // namespace odomd::tools
