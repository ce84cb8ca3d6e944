#include "tools/live/daemon_segment.hpp"

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <thread>

#include "tools/live/socket_path.hpp"
#include "tools/live/status_socket.hpp"
#include "tools/live/status_values.hpp"

namespace odomd::tools {
namespace {

namespace fs = std::filesystem;

std::string text_of(const Json& value) {
  return value.is_string() ? value.get<std::string>() : std::string{};
}

// std::filesystem::equivalent() takes no sockets.
bool same_file(const fs::path& a, const fs::path& b) {
  std::error_code missing;
  const fs::path full = fs::canonical(a, missing);
  return !missing && full == fs::canonical(b, missing);
}

// Nothing if nobody answers, or a daemon other than that of the camera socket. A status socket
// without a name is the default one.
std::optional<std::string> segment_from_status(const std::string& named, const fs::path& camera) {
  try {
    const std::string socket = socket_path(named, "status.sock");
    const Json status = parse_status(fetch_status(socket), socket);
    const std::string segment = segment_of(status);
    if (segment.empty() || !same_file(text_of(member(member(status, "camera"), "socket")), camera))
      return std::nullopt;
    return segment;
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

}  // namespace

std::string segment_of(const Json& status) {
  return text_of(member(status, "shm"));
}

std::string segment_behind_camera(const std::string& socket, double wait_s) {
  using std::chrono::steady_clock;
  const auto start = steady_clock::now();
  while (true) {
    const fs::path neighbour = fs::path{socket}.parent_path() / "status.sock";
    for (const std::string& status : {neighbour.string(), std::string{}})
      if (auto segment = segment_from_status(status, socket)) return *std::move(segment);
    if (std::getenv("ODOM_SHM") != nullptr) return {};
    const std::chrono::duration<double> waited = steady_clock::now() - start;
    if (waited.count() >= wait_s) {
      throw std::runtime_error(
          socket +
          ": no status socket next to it names the segment of its daemon; give it with --shm");
    }
    std::this_thread::sleep_for(std::chrono::milliseconds{20});
  }
}

}  // namespace odomd::tools
