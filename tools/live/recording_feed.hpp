// The recorder's end of odomd's record socket: receives its messages one after the other.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "base/file_descriptor.hpp"
#include "daemon/core/recording_wire.hpp"
#include "tools/live/daemon_link.hpp"

namespace odomd::tools {

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
