// The connections of the camera processes. Housekeeping admits and closes them; in between the beat
// reads them. Both share four slots without a lock, each handed over with one atomic word.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/counter.hpp"
#include "base/file_descriptor.hpp"
#include "daemon/journal/event.hpp"
#include "daemon/sockets/camera_wire.hpp"
#include "daemon/sockets/local_socket.hpp"
#include "estimator/common/measurement.hpp"

namespace odomd::daemon {

class CameraDoor {
 public:
  static constexpr std::size_t max_connections = 4;
  static constexpr std::size_t max_messages_per_drain = 8;  ///< of each connection
  static constexpr std::size_t max_poses = max_connections * max_messages_per_drain;
  /// A connection that sent no valid message for this long makes room for a new one.
  static constexpr std::int64_t idle_ns = 2'000'000'000;

  CameraDoor() = default;
  ~CameraDoor();
  CameraDoor(const CameraDoor&) = delete;
  CameraDoor& operator=(const CameraDoor&) = delete;

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
  /// Hands a connection to the beat. When all slots are taken, it replaces the connection that has
  /// been idle longest; if none is idle, it is refused.
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
    Peer peer;          // housekeeping's
    Counter messages;   // the beat's, reset while the slot is free
    Counter malformed;  // the beat's
    Counter heard_ns;   // the beat's: time of the last valid message, at first of the admission
    FileDescriptor successor;  // housekeeping's: replaces the connection, which is being ended
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
