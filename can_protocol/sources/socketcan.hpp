// One CAN interface of the kernel as a frame source.
//
// The daemon only listens: no function here sends.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "base/file_descriptor.hpp"
#include "can_protocol/sources/frame_receiver.hpp"
#include "can_protocol/sources/frame_source.hpp"
#include "can_protocol/sources/source_warnings.hpp"

namespace odomd::can {

struct SocketCanSettings {
  std::uint8_t bus = 0;             ///< index of the bus in its frames
  std::vector<std::uint32_t> keys;  ///< identifiers to listen to (frame_key); empty: all
  StampSource stamps = StampSource::software;
  int receive_buffer = 1 << 20;  ///< bytes of the socket's queue
};

/// The beat drains, housekeeping maintains, and neither waits for the other: a new socket is handed
/// over through one atomic, and the old one returns through another and is closed by housekeeping.
/// An interface that is missing, at the start or later, is `gone` until `maintain` finds it; one
/// that is down keeps its socket.
class SocketCanSource final : public FrameSource {
 public:
  /// Throws std::system_error when the kernel has no CAN or refuses the socket, and
  /// std::invalid_argument when the interface is not a CAN interface.
  SocketCanSource(std::string interface, SocketCanSettings settings);
  ~SocketCanSource() override;
  SocketCanSource(const SocketCanSource&) = delete;
  SocketCanSource& operator=(const SocketCanSource&) = delete;

  std::size_t drain(std::span<Frame> frames, std::int64_t tick_ns,
                    std::int64_t now_ns) noexcept override;
  [[nodiscard]] LinkState link() const noexcept override {
    return link_.load(std::memory_order_relaxed);
  }
  [[nodiscard]] const SourceCounters& counters() const noexcept override { return counters_; }
  [[nodiscard]] const std::string& name() const noexcept override { return interface_; }
  void maintain() noexcept override;
  [[nodiscard]] std::vector<std::string> warnings() const override { return warnings_.list(); }

 private:
  static constexpr int none = -1;

  void connect();
  FileDescriptor open_socket(int index);
  void offer(FileDescriptor socket);
  void close_retired() noexcept;
  void adopt_offered() noexcept;
  void note_error(int error) noexcept;

  std::string interface_;
  SocketCanSettings settings_;
  SourceCounters counters_;
  std::atomic<LinkState> link_{LinkState::gone};

  // Between the two threads: descriptors, `none` when empty.
  std::atomic<int> offered_{none};  // housekeeping to beat: the socket to read from now on
  std::atomic<int> retired_{none};  // beat to housekeeping: the socket to close
  std::atomic<int> dead_{none};     // beat to housekeeping: the socket whose interface is gone

  // Used by the beat only.
  int socket_ = none;
  FrameReceiver receiver_;

  // Used by housekeeping only.
  FileDescriptor control_;  // to query interfaces
  int newest_ = none;       // the socket offered last
  int bound_index_ = 0;     // index of the interface of newest_; 0: none
  SourceWarnings warnings_;
};

}  // namespace odomd::can
