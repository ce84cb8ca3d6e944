// The connections of the camera processes. Housekeeping admits and closes them; in between the beat
// reads them. The two share four slots of one atomic word each, without a lock.
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

  /// Hands a connection to the beat; false when all slots are taken.
  bool admit(FileDescriptor connection, Peer peer);

  /// Closes connections that the peer has closed.
  void close_ended() noexcept;

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
  };

  enum class Received : std::uint8_t { pose, malformed, nothing, ended };
  static Received receive(int descriptor, const MessageClocks& clocks, std::int64_t now_ns,
                          estimator::CameraPose& pose, EventRing& events) noexcept;

  std::array<Slot, max_connections> slots_;
};

}  // namespace odomd::daemon
