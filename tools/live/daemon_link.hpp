// Finds a running daemon and connects to it: its sockets and its segment, or one line that says why
// that fails. A given socket selects its daemon, not the one with the default names.
#pragma once

#include <chrono>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>
#include <odom/odom.hpp>

#include "base/file_descriptor.hpp"

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

/// For a person why the socket at `path`, of this leaf, could not be connected to, and the fix.
[[nodiscard]] std::string why_unconnected(const std::string& path, int error,
                                          std::string_view leaf);
/// Throws it: NobodyThere, or std::runtime_error.
[[noreturn]] void fail_to_connect(const std::string& path, int error, std::string_view leaf);

/// Some seconds in which a daemon may appear.
class Waiting {
 public:
  explicit Waiting(double seconds) : seconds_(seconds) {}
  /// Naps, unless the time is over.
  [[nodiscard]] bool goes_on() const;

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::chrono::duration<double> seconds_;
};

/// Connects to a socket; none, with errno, if it fails. `timeout` is that of each read and write;
/// 0: none. Throws std::invalid_argument for a path that cannot be a socket's.
[[nodiscard]] FileDescriptor connect_to(const std::string& path,
                                        std::chrono::milliseconds timeout = {});

/// The document as it came. Throws std::invalid_argument for a path that cannot be a socket's,
/// std::runtime_error where nobody answers in time.
[[nodiscard]] std::string fetch_status(const std::filesystem::path& socket,
                                       std::chrono::milliseconds timeout = std::chrono::seconds{2});

/// The document as an object. Throws std::runtime_error, which names the socket, where the answer
/// is something else.
[[nodiscard]] nlohmann::json parse_status(const std::string& document,
                                          const std::filesystem::path& socket);

/// The requested segment in words: the name, or the defaults.
[[nodiscard]] std::string segment_asked_for(const std::string& name);

/// `name` empty: the library's defaults. Tries again for `wait_s` seconds while there is no
/// segment. Throws std::invalid_argument for a name that is not usable, std::runtime_error else.
[[nodiscard]] odom::Client attach(const std::string& name, double wait_s);

/// `shm` of a status document; empty where it names none.
[[nodiscard]] std::string segment_of(const nlohmann::json& status);

/// The segment of the daemon that takes camera poses at `socket`, from the status socket next to it
/// or else the service's. If neither answers: empty, for the default names, if $ODOM_SHM is set.
/// Tries again for `wait_s` seconds, then throws std::runtime_error.
[[nodiscard]] std::string segment_behind_camera(const std::string& socket, double wait_s);

}  // namespace odomd::tools
