// Finds the segment of a daemon through its sockets: a given socket selects its daemon, not the one
// with the default names.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace odomd::tools {

/// `shm` of a status document; empty where it names none.
[[nodiscard]] std::string segment_of(const nlohmann::json& status);

/// The segment of the daemon that takes camera poses at `socket`, from the status socket next to it
/// or else the service's. If neither answers: empty, for the default names, if $ODOM_SHM is set.
/// Tries again for `wait_s` seconds, then throws std::runtime_error.
[[nodiscard]] std::string segment_behind_camera(const std::string& socket, double wait_s);

}  // namespace odomd::tools
