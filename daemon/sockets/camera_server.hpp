// The connections of the camera processes, and their messages. Housekeeping admits and closes the
// connections; in between the beat reads them. Both share four slots without a lock, each handed
// over with one atomic word.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include <odom/odom.h>

#include "base/counter.hpp"
#include "base/file_descriptor.hpp"
#include "base/wall_clock.hpp"
#include "daemon/journal/event.hpp"
#include "daemon/sockets/local_socket.hpp"
#include "estimator/common/measurement.hpp"

namespace odomd::daemon {

/// Why a message is invalid.
enum class MalformedCause : std::uint8_t {
  none,
  size,      ///< not sizeof(odom_camera_message) bytes
  magic,     ///< not ODOM_CAMERA_MAGIC
  version,   ///< not ODOM_CAMERA_VERSION
  clock,     ///< not an odom_clock
  no_log,    ///< stamped with the log clock, but no frame of a log has arrived
  time,      ///< so far away that it cannot be converted
  reserved,  ///< the reserved word is not 0
  count
};
inline constexpr std::array<std::string_view, static_cast<std::size_t>(MalformedCause::count)>
    malformed_texts{"",
                    "it is not 80 bytes long",
                    "it does not begin with the magic number",
                    "this odomd does not know its version",
                    "it names an unknown clock",
                    "it is stamped with the log clock, but no log is being played yet",
                    "its time is out of range",
                    "its reserved word is not 0"};

/// The state of the clocks that a message may use.
struct MessageClocks {
  const WallClock& wall;               ///< has been read at least once
  std::optional<std::int64_t> log_ns;  ///< log clock - CLOCK_MONOTONIC, while a log is played
};

struct CameraMessage {
  MalformedCause cause = MalformedCause::none;
  estimator::CameraPose pose;  ///< of the reference point; valid when cause is none
};

/// `bytes` is the received message, `size` its original size (it may have been truncated).
/// Non-finite values are accepted: the filter has a verdict for them. Real-time safe.
[[nodiscard]] CameraMessage read_camera_message(std::span<const std::byte> bytes, std::size_t size,
                                                const MessageClocks& clocks,
                                                std::int64_t arrival_ns) noexcept;

class CameraServer {
 public:
  static constexpr std::size_t max_connections = 4;
  static constexpr std::size_t max_messages_per_drain = 8;  ///< of each connection
  static constexpr std::size_t max_poses = max_connections * max_messages_per_drain;
  /// A connection that sent no valid message for this long makes room for a new one.
  static constexpr std::int64_t idle_ns = 2'000'000'000;

  CameraServer() = default;
  ~CameraServer();
  CameraServer(const CameraServer&) = delete;
  CameraServer& operator=(const CameraServer&) = delete;

  // The beat's ----------------------------------------------------------------------------------

  struct Drained {
    std::size_t poses = 0;
    std::size_t malformed = 0;
  };
  /// Reads the messages that have arrived, at most max_messages_per_drain per connection; the rest
  /// waits for the next tick. `poses` must hold max_poses. Real-time safe; the only system call is
  /// recvmsg.
  Drained drain(std::span<estimator::CameraPose> poses, const MessageClocks& clocks,
                std::int64_t now_ns, EventRing& events) noexcept;

  // Housekeeping's ------------------------------------------------------------------------------

  enum class Admission : std::uint8_t { free_slot, in_place_of_idle, refused };
  /// Hands a new connection to the beat. When all slots are taken, the new one replaces the
  /// connection that has been idle longest, or is refused if none is idle.
  Admission admit(FileDescriptor connection, Peer peer, std::int64_t now_ns);

  /// Tells the sender the reason, a negative errno, and closes the connection.
  void refuse(FileDescriptor connection, std::int32_t reason) noexcept;
  /// Connections that were refused. Any thread.
  [[nodiscard]] std::uint64_t refused() const noexcept { return refused_.get(); }

  /// Closes connections that have ended, and admits their successors.
  void close_ended(std::int64_t now_ns) noexcept;

  struct Connection {
    bool open = false;
    Peer peer;
    std::uint64_t messages = 0;
    std::uint64_t malformed = 0;
  };
  [[nodiscard]] std::array<Connection, max_connections> connections() const;

 private:
  /// `state` is the descriptor while the beat may read it (>= 0), `free`, or `ended(descriptor)`
  /// when the beat has seen the end and housekeeping is to close it.
  struct Slot {
    static constexpr int free = -1;
    static constexpr int ended(int descriptor) { return -2 - descriptor; }

    std::atomic<int> state{free};
    Peer peer;                 // housekeeping's
    Counter messages;          // the beat's, reset while the slot is free
    Counter malformed;         // the beat's
    Counter heard_ns;          // the beat's: time of the last valid message, or of the admission
    FileDescriptor successor;  // housekeeping's: replaces the connection once that has ended
    Peer successor_peer;
  };
  static void open(Slot& slot, FileDescriptor connection, Peer peer, std::int64_t now_ns) noexcept;

  enum class Received : std::uint8_t { pose, malformed, nothing, ended };
  static Received receive(int descriptor, const MessageClocks& clocks, std::int64_t now_ns,
                          estimator::CameraPose& pose, EventRing& events) noexcept;

  std::array<Slot, max_connections> slots_;
  Counter refused_;  // housekeeping's
};

}  // namespace odomd::daemon
