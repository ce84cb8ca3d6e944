// The daemon's sockets, by the rule that the daemon itself follows (shm_api/libodom/service.h).
#pragma once

#include <stdexcept>
#include <string>

namespace odomd::tools {

/// No odomd listens there, yet or any more.
class NobodyThere : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// `named` where it is not empty; else the socket that is there: $XDG_RUNTIME_DIR/odomd/LEAF, that
/// of the service's first instance by name, /run/odomd/can0/LEAF, or /run/odomd/LEAF. `leaf` is
/// "status.sock", "camera.sock" or "record.sock". Throws NobodyThere, which names these places and
/// the fix, where none is there.
[[nodiscard]] std::string socket_path(const std::string& named, const std::string& leaf);

}  // namespace odomd::tools
