#include "tools/live/status_socket.hpp"

#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <system_error>

#include "base/file_descriptor.hpp"
#include "tools/cli/json_text.hpp"

namespace odomd::tools {
namespace {

constexpr const char* hint =
    "is odomd running? [status] socket of its configuration names the path";

constexpr std::size_t largest_document = std::size_t{16} << 20U;

std::string why(int error) {
  switch (error) {
    case ENOENT:
    case ENOTDIR:
      return std::string{"no such socket; "} + hint;
    case ECONNREFUSED:
      return std::string{"nobody listens; "} + hint;
    case EACCES:
      return "not allowed; join the group of the socket (the service's: odom)";
    default:
      return std::generic_category().message(error);
  }
}

}  // namespace

std::string fetch_status(const std::filesystem::path& socket, std::chrono::milliseconds timeout) {
  const std::string path = socket.string();
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof address.sun_path) {
    throw std::invalid_argument(path + ": the path of a socket has 1 to 107 characters");
  }
  std::memcpy(address.sun_path, path.c_str(), path.size() + 1);

  const FileDescriptor connection{::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)};
  const auto whole = std::chrono::floor<std::chrono::seconds>(timeout);
  const timeval time_out{whole.count(), std::chrono::microseconds{timeout - whole}.count()};
  ::setsockopt(connection.get(), SOL_SOCKET, SO_RCVTIMEO, &time_out, sizeof time_out);
  ::setsockopt(connection.get(), SOL_SOCKET, SO_SNDTIMEO, &time_out, sizeof time_out);
  if (::connect(connection.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) !=
      0) {
    throw std::runtime_error(path + ": " + why(errno));
  }

  std::string document;
  std::array<char, 16384> piece{};
  while (true) {
    const auto size = ::recv(connection.get(), piece.data(), piece.size(), 0);
    if (size == 0) return document;
    if (size < 0 && errno == EINTR) continue;
    if (size < 0 && errno == EAGAIN) {
      throw std::runtime_error(path + ": no answer; is the daemon stopped?");
    }
    if (size < 0) throw std::runtime_error(path + ": " + why(errno));
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

}  // namespace odomd::tools
