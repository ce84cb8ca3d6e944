// The socket for `odom record`. Housekeeping sends the contents of the tap as fast as the recorder
// reads; the rings are the buffer in between. There is one recorder at a time, so one that stops
// reading is dropped.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/file_descriptor.hpp"
#include "can_protocol/bus_names.hpp"
#include "daemon/core/config.hpp"
#include "daemon/core/recording_tap.hpp"
#include "daemon/core/recording_wire.hpp"
#include "daemon/journal/journal.hpp"
#include "daemon/sockets/local_socket.hpp"

namespace odomd::daemon {

/// The parts of the daemon that are recorded; they outlive this object.
struct Recorded {
  const Config& config;
  const can::BusNames& buses;
  std::uint64_t instance_id = 0;
  RecordingTap& tap;
};

class RecorderServer {
 public:
  RecorderServer(const Recorded& recorded, LocalSocket socket, std::vector<RecordingFile> files);

  /// The listening socket, to poll and to renew.
  [[nodiscard]] LocalSocket& socket() noexcept { return socket_; }

  /// Accepts a recorder, or sends it the reason for refusing it.
  void accept(std::int64_t now_ns, Journal& journal);

  /// Call every turn: sends what is available. Drops a recorder that reads nothing for ten seconds,
  /// or that fell behind until the rings were full and does not read the rest within that time.
  void serve(std::int64_t now_ns, Journal& journal);

  /// Call when the daemon stops: sends the remaining ticks and the end to the recorder. Waits half
  /// a second for a slow one.
  void close(Journal& journal);

 private:
  enum class Stage : std::uint8_t {
    waiting,    ///< for the beat to begin
    streaming,  ///< ticks
    ended       ///< the last bytes are being sent
  };

  void begin_stream();
  void send_buses();
  void append_ticks();
  void append_tick();
  void append(RecordingMessage kind, std::string_view bytes);
  /// Sends as much as fits; false when the recorder has disconnected.
  [[nodiscard]] bool flush();
  void flush_until_timeout();
  void end(std::string_view why);
  void drop(std::string_view why, Journal& journal);
  [[nodiscard]] std::string hello() const;

  Recorded recorded_;
  LocalSocket socket_;
  std::vector<RecordingFile> files_;

  FileDescriptor recorder_;
  Peer peer_;
  Stage stage_ = Stage::waiting;
  bool begun_ = false;       // the tap was asked to begin
  std::size_t buses_ = 0;    // number of buses that the recorder knows
  std::uint64_t ticks_ = 0;  // sent
  std::string out_;          // not sent yet
  std::size_t out_at_ = 0;
  std::int64_t moved_ns_ = 0;  // when the recorder last read something, or had nothing to read
};

}  // namespace odomd::daemon
