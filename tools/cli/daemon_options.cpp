#include "tools/cli/daemon_options.hpp"

#include <cctype>

#include <fmt/format.h>

namespace odomd::tools {

void add_segment_option(Command command, std::string& name, SegmentElse otherwise,
                        const Rules& rules) {
  command.add(
      "--shm", "NAME", name,
      fmt::format(
          "Shared memory segment: a name (/odomd) or a path; default: {}$ODOM_SHM; otherwise "
          "/odomd, if it exists; otherwise /run/odomd/INTERFACE/pose of the service",
          otherwise == SegmentElse::of_socket
              ? "with --socket, the segment of that daemon; otherwise "
              : ""),
      rules);
}

void add_socket_option(Command command, std::string& path, const std::string& door,
                       const Rules& rules) {
  std::string capital = door;
  capital.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(door.front())));
  command.add(
      "--socket", "PATH", path,
      fmt::format(
          "{} socket of the daemon; default: $XDG_RUNTIME_DIR/odomd/{}.sock, if it exists; "
          "otherwise /run/odomd/INTERFACE/{}.sock of the service; otherwise /run/odomd/{}.sock",
          capital, door, door, door),
      rules);
}

void add_wait_option(Command command, double& seconds) {
  command.add("--wait", "S", seconds, "Wait this long for a daemon to appear [s]; default: 0",
              {not_negative()});
}

}  // namespace odomd::tools
