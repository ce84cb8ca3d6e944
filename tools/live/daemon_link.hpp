// Finds a running daemon and connects to its sockets and its segment, or gives the reason for a
// failure in one line. A given socket selects its daemon, not the one with the default names.
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

/// No odomd listens there: it has not started, or has ended.
class NobodyThere : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// `named` unless empty; otherwise the first existing one of $XDG_RUNTIME_DIR/odomd/LEAF, the
/// service's first instance by name, /run/odomd/can0/LEAF, and /run/odomd/LEAF. `leaf` is
/// "status.sock", "camera.sock" or "record.sock". Throws NobodyThere with these places and the fix
/// if none exists.
[[nodiscard]] std::string socket_path(const std::string& named, const std::string& leaf);

/// Why the socket at `path`, with this leaf, could not be connected to, and the fix; for people.
[[nodiscard]] std::string why_unconnected(const std::string& path, int error,
                                          std::string_view leaf);
/// Throws that text as NobodyThere or std::runtime_error.
[[noreturn]] void fail_to_connect(const std::string& path, int error, std::string_view leaf);

/// A limited time in which a daemon may appear.
class Waiting {
 public:
  explicit Waiting(double seconds, std::chrono::milliseconds nap = std::chrono::milliseconds{20})
      : seconds_(seconds), nap_(nap) {}
  /// Sleeps for a moment and returns true; false once the time is over.
  [[nodiscard]] bool goes_on() const;

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::chrono::duration<double> seconds_;
  std::chrono::milliseconds nap_;
};

/// Connects to a socket; returns an empty descriptor, with errno, if that fails. `timeout` limits
/// each read and write; 0: none. Throws std::invalid_argument for a path that no socket can have.
[[nodiscard]] FileDescriptor connect_to(const std::string& path,
                                        std::chrono::milliseconds timeout = {});

/// The document as received. Throws std::invalid_argument for a path that no socket can have,
/// std::runtime_error if nobody answers in time.
[[nodiscard]] std::string fetch_status(const std::filesystem::path& socket,
                                       std::chrono::milliseconds timeout = std::chrono::seconds{2});

/// The document as an object. Throws std::runtime_error with the socket's name if it is not one.
[[nodiscard]] nlohmann::json parse_status(const std::string& document,
                                          const std::filesystem::path& socket);

/// The requested segment for messages: its name, or the defaults.
[[nodiscard]] std::string segment_asked_for(const std::string& name);

/// Attaches to the segment `name`; empty: the library's defaults. Retries for `wait_s` seconds
/// while there is no segment. Throws std::invalid_argument for an invalid name, std::runtime_error
/// for other failures.
[[nodiscard]] odom::Client attach(const std::string& name, double wait_s);

/// The member `shm` of a status document; empty if missing.
[[nodiscard]] std::string segment_of(const nlohmann::json& status);

}  // namespace odomd::tools
