// Which segment a daemon publishes in, asked at its sockets: who names a socket means the daemon
// behind it, and not the one that the default names would find.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace odomd::tools {

/// `shm` of a status document; empty where it names none.
[[nodiscard]] std::string segment_of(const nlohmann::json& status);

/// The segment of the daemon that takes camera poses at `socket`, as the status socket beside it,
/// else the service's, tells. Where neither does: empty, for the default names, if $ODOM_SHM is
/// set. Tries again for `wait_s` seconds, then throws std::runtime_error.
[[nodiscard]] std::string segment_behind_camera(const std::string& socket, double wait_s);

}  // namespace odomd::tools
