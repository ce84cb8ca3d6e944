#include "tools/cli/daemon_options.hpp"

#include <cctype>

#include <fmt/format.h>

namespace odomd::tools {

Option add_segment_option(Command command, std::string& name, SegmentElse otherwise) {
  return command
      .add_option(
          "--shm", name,
          fmt::format(
              "Segment: a name (/odomd) or a path; else {}$ODOM_SHM, /odomd, or "
              "the service's, /run/odomd/can0/pose",
              otherwise == SegmentElse::of_socket ? "the one of the daemon at --socket, " : ""))
      .type_name("NAME");
}

Option add_socket_option(Command command, std::string& path, const std::string& door) {
  std::string capital = door;
  capital.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(door.front())));
  return command
      .add_option("--socket", path,
                  fmt::format("{} socket of the daemon; else the first that is there of "
                              "$XDG_RUNTIME_DIR/odomd/{}.sock, the service's, "
                              "/run/odomd/can0/{}.sock, and /run/odomd/{}.sock",
                              capital, door, door, door))
      .type_name("PATH");
}

Option add_wait_option(Command command, double& seconds) {
  return command
      .add_option("--wait", seconds, "Wait this long for a daemon to appear [s]; default: 0")
      .not_negative()
      .type_name("S");
}

}  // namespace odomd::tools
