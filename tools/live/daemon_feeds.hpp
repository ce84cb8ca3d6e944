// The streams between a tool and the daemon: camera poses to it, one by one or in the pace of a
// log, and a recording from it.
#pragma once

#include <odom/odom.hpp>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/file_descriptor.hpp"
#include "daemon/core/recording_wire.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/live/daemon_link.hpp"

namespace odomd::tools {

/// The pose as a message, its capture time on `clock`.
[[nodiscard]] odom_camera_message camera_message(const estimator::CameraPose& pose,
                                                 odom_clock clock);

/// Whether the first pose of a connection waits until the daemon has read it, which shows whether
/// the daemon accepts the connection.
enum class Admission : std::uint8_t { awaited, assumed };

/// A connection to a camera socket, for use by one thread.
class CameraFeed {
 public:
  /// Connects to the socket `named`; empty: the default one. Retries for `wait_s` seconds while
  /// nobody listens. Throws std::runtime_error with the reason and the fix.
  CameraFeed(const std::string& named, double wait_s, Admission admission = Admission::awaited);

  [[nodiscard]] const std::string& socket() const { return socket_; }

  /// Sends one pose with its capture time on `clock`. Waits some milliseconds for a daemon that is
  /// behind, and for the admission if it is awaited. False if there is no daemon or it refuses the
  /// connection (both may change); other failures throw.
  bool send(const estimator::CameraPose& pose, odom_clock clock);

  /// Why the last connection was refused; empty if none was.
  [[nodiscard]] const std::string& refusal() const { return refusal_; }

 private:
  std::string socket_;
  odom::CameraSender sender_;
  Admission admission_;
  bool admitted_ = false;
  std::string refusal_;
};

struct PlayedLog {
  std::uint64_t sent = 0;
  std::uint64_t late = 0;     ///< left out: the daemon's log clock had already passed them
  std::uint64_t refused = 0;  ///< no daemon was there, or it refused them
  bool daemon_ended = false;  ///< the daemon ended before the log
};

/// Plays a log in step with the log that the daemon plays: sends each pose when the daemon's log
/// clock reaches its t_arrival. Waits `wait_s` seconds for the daemon to start its log, and throws
/// std::runtime_error if it does not.
[[nodiscard]] PlayedLog play_with_daemon(CameraFeed& feed, odom::Client& client,
                                         std::span<const estimator::CameraPose> poses,
                                         double wait_s);

/// Plays a log on its own clock from now on; capture times are moved to CLOCK_MONOTONIC.
[[nodiscard]] PlayedLog play_from_now(CameraFeed& feed,
                                      std::span<const estimator::CameraPose> poses);

/// The recorder's end of odomd's record socket: receives its messages one after the other. For use
/// by one thread.
class RecordingFeed {
 public:
  /// Connects. Throws NobodyThere, or std::runtime_error with another reason.
  explicit RecordingFeed(const std::filesystem::path& socket);

  struct Message {
    daemon::RecordingMessage kind = daemon::RecordingMessage::hello;
    std::string_view bytes;  ///< valid until the next call
  };
  /// The next message; nothing if none came within the timeout, or if no more will (see ended).
  /// Throws std::runtime_error for an invalid message.
  [[nodiscard]] std::optional<Message> next(std::chrono::milliseconds timeout);

  /// Whether odomd has closed the connection.
  [[nodiscard]] bool ended() const { return ended_; }

  /// Call after the end: whether odomd still runs, and so has dropped this recorder. Waits half a
  /// second for a process that is ending.
  [[nodiscard]] bool is_daemon_running() const;

 private:
  [[nodiscard]] std::optional<Message> buffered();

  std::string name_;
  FileDescriptor connection_;
  FileDescriptor daemon_;  // odomd's process; empty if it is not visible from here
  std::string buffer_;
  std::size_t at_ = 0;
  bool ended_ = false;
};

}  // namespace odomd::tools
