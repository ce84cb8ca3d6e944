// The paths of the service's sockets, the default if no path is given.
#pragma once

#include <string>

namespace odomd::tools {

/// `named` where it is not empty; else `leaf` ("status.sock") of the service's first instance that
/// runs, by name: /run/odomd/can0/status.sock; else /run/odomd/status.sock.
[[nodiscard]] std::string service_path(const std::string& named, const std::string& leaf);

}  // namespace odomd::tools
