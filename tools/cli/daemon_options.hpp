// The options with which a command finds the daemon, the same for all commands.
#pragma once

#include <string>

#include "tools/cli/command.hpp"

namespace odomd::tools {

/// The segment without --shm: the library's defaults; or, for commands with --socket, the segment
/// of the daemon at that socket if it is given.
enum class SegmentElse { default_names, of_socket };

/// --shm: the segment in which the daemon publishes.
void add_segment_option(Command command, std::string& name,
                        SegmentElse otherwise = SegmentElse::default_names,
                        const Rules& rules = {});

/// --socket. `door` is the purpose of the socket: "status", "record", "camera".
void add_socket_option(Command command, std::string& path, const std::string& door,
                       const Rules& rules = {});

/// --wait [s].
void add_wait_option(Command command, double& seconds);

}  // namespace odomd::tools
