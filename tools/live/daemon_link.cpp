#include "tools/live/daemon_link.hpp"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/un.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <new>
#include <system_error>
#include <thread>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "shm_api/libodom/service.h"
#include "tools/cli/text.hpp"

namespace odomd::tools {
namespace {

constexpr const char* service = ODOMI_SERVICE_DIRECTORY;

/// The places where socket_path() looks, in order.
std::string places_of(const std::string& leaf) {
  const char* runtime = std::getenv("XDG_RUNTIME_DIR");
  const std::string own = runtime != nullptr && *runtime == '/'
                              ? std::string{runtime} + "/odomd/" + leaf
                              : "$XDG_RUNTIME_DIR (not set)";
  return own + ", " + service + "/*/" + leaf + ", " + service + "/" + leaf;
}

constexpr std::size_t largest_document = std::size_t{16} << 20U;

using nlohmann::json;

}  // namespace

std::string socket_path(const std::string& named, const std::string& leaf) {
  if (!named.empty()) return named;
  char* found = nullptr;
  if (odomi_socket_path(service, leaf.c_str(), &found) != ODOM_OK) throw std::bad_alloc();
  std::string path(found);
  std::free(found);  // NOLINT(cppcoreguidelines-no-malloc): malloc'ed by C
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0 && errno == ENOENT)
    fail_to_connect(places_of(leaf), ENOENT, leaf);
  return path;
}

std::string why_unconnected(const std::string& path, int error, std::string_view leaf) {
  const bool camera = leaf == "camera.sock";
  const std::string other =
      fmt::format("--socket names another path{}",
                  leaf == "status.sock" ? " ([status] socket of its configuration)" : "");
  switch (error) {
    case ENOENT:
    case ENOTDIR:
      return fmt::format("{}: no such socket; is odomd running{}? {}", path,
                         camera ? ", with a [camera] table" : "", other);
    case ECONNREFUSED:
      return path + ": nobody listens; is odomd running? " + other;
    case EACCES:
    case EPERM:
      return fmt::format("{}: not allowed; join the group {}", path,
                         camera                  ? "of the socket ([camera] socket_group)"
                         : leaf == "record.sock" ? "that may read the pose ([shm] group)"
                                                 : "of the socket (the service's: odom)");
    case EBUSY:
      return path +
             ": refused: odomd has as many camera connections as it takes; stop one of the senders";
    default:
      return path + ": " + std::generic_category().message(error);
  }
}

void fail_to_connect(const std::string& path, int error, std::string_view leaf) {
  const std::string why = why_unconnected(path, error, leaf);
  if (error == ENOENT || error == ENOTDIR || error == ECONNREFUSED) throw NobodyThere(why);
  throw std::runtime_error(why);
}

bool Waiting::goes_on() const {
  if (std::chrono::steady_clock::now() - start_ >= seconds_) return false;
  std::this_thread::sleep_for(nap_);
  return true;
}

FileDescriptor connect_to(const std::string& path, std::chrono::milliseconds timeout) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof address.sun_path)
    throw std::invalid_argument(path + ": the path of a socket has 1 to 107 characters");
  std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
  FileDescriptor connection{::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)};
  const auto whole = std::chrono::floor<std::chrono::seconds>(timeout);
  const timeval time_out{whole.count(), std::chrono::microseconds{timeout - whole}.count()};
  ::setsockopt(connection.get(), SOL_SOCKET, SO_RCVTIMEO, &time_out, sizeof time_out);
  ::setsockopt(connection.get(), SOL_SOCKET, SO_SNDTIMEO, &time_out, sizeof time_out);
  if (::connect(connection.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0)
    return connection;
  const int error = errno;
  connection = {};
  errno = error;
  return connection;
}

std::string fetch_status(const std::filesystem::path& socket, std::chrono::milliseconds timeout) {
  const std::string path = socket.string();
  const FileDescriptor connection = connect_to(path, timeout);
  if (!connection) throw std::runtime_error(why_unconnected(path, errno, "status.sock"));
  std::string document;
  std::array<char, 16384> piece{};
  while (true) {
    const auto size = ::recv(connection.get(), piece.data(), piece.size(), 0);
    if (size == 0) return document;
    if (size < 0 && errno == EINTR) continue;
    if (size < 0 && errno == EAGAIN) {
      throw std::runtime_error(path + ": no answer; is the daemon stopped?");
    }
    if (size < 0) throw std::runtime_error(why_unconnected(path, errno, "status.sock"));
    document.append(piece.data(), static_cast<std::size_t>(size));
    if (document.size() > largest_document)
      throw std::runtime_error(path + ": the answer is too long; is this odomd's socket?");
  }
}

nlohmann::json parse_status(const std::string& document, const std::filesystem::path& socket) {
  constexpr bool throwing = false;
  if (!is_nested_too_deep(document)) {
    auto json = nlohmann::json::parse(document, nullptr, throwing);
    if (json.is_object()) return json;
  }
  throw std::runtime_error(socket.string() +
                           ": the answer is not a status document; is this odomd's socket?");
}

std::string segment_asked_for(const std::string& name) {
  if (!name.empty()) return name;
  const char* named = std::getenv("ODOM_SHM");
  return named != nullptr ? std::string{"$ODOM_SHM = "} + named : "/odomd, /run/odomd/*/pose";
}

odom::Client attach(const std::string& name, double wait_s) {
  const Waiting waiting{wait_s};
  while (true) {
    auto opened = odom::Client::open(name.empty() ? nullptr : name.c_str());
    if (opened.has_value()) return std::move(opened.value);
    if (opened.status == ODOM_INVALID)
      throw std::invalid_argument(segment_asked_for(name) +
                                  ": not a name of a segment; use /odomd or a path");
    if (opened.status != ODOM_NO_SEGMENT || !waiting.goes_on())
      throw std::runtime_error(segment_asked_for(name) + ": " + opened.message());
  }
}

std::string segment_of(const json& status) {
  const json name = status.value("shm", json{});
  return name.is_string() ? name.get<std::string>() : std::string{};
}

}  // namespace odomd::tools
