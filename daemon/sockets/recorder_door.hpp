// Where `odom record` connects. Housekeeping takes what the tap holds and sends it, as fast as the
// recorder takes it; the rings are the buffer in between. One recorder at a time, so one that takes
// nothing any more loses its place.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/file_descriptor.hpp"
#include "can_protocol/bus_names.hpp"
#include "daemon/core/config.hpp"
#include "daemon/core/recording_files.hpp"
#include "daemon/core/recording_tap.hpp"
#include "daemon/core/recording_wire.hpp"
#include "daemon/journal/journal.hpp"
#include "daemon/sockets/local_socket.hpp"

namespace odomd::daemon {

/// What is recorded: of the daemon, and outlives the door.
struct Recorded {
  const Config& config;
  const can::BusNames& buses;
  std::uint64_t instance_id = 0;
  RecordingTap& tap;
};

class RecorderDoor {
 public:
  RecorderDoor(const Recorded& recorded, LocalSocket socket, std::vector<RecordingFile> files);

  /// The listening socket, to poll.
  [[nodiscard]] int get() const noexcept { return socket_.get(); }

  /// Lets a recorder in, or says why not.
  void accept(std::int64_t now_ns, Journal& journal);

  /// Every turn: sends what there is. A recorder that takes nothing for ten seconds is dropped, and
  /// so is one that fell behind until the rings were full and does not take the rest in that time.
  void serve(std::int64_t now_ns, Journal& journal);

  /// The daemon ends: says so to the recorder, with the ticks that are there. Waits half a second
  /// for one that is slow.
  void close(std::int64_t now_ns, Journal& journal);

 private:
  enum class Stage : std::uint8_t {
    waiting,    ///< for the beat to begin
    streaming,  ///< ticks
    ended       ///< the last bytes are on their way
  };

  void begin_stream();
  void send_buses();
  void append_ticks();
  void append_tick();
  void append(RecordingMessage kind, std::string_view bytes);
  /// Sends what there is room for; false where nobody listens any more.
  [[nodiscard]] bool flush();
  void flush_patiently();
  void end(std::string_view why);
  void drop(std::string_view why, std::int64_t now_ns, Journal& journal);
  [[nodiscard]] std::string hello() const;

  Recorded recorded_;
  LocalSocket socket_;
  std::vector<RecordingFile> files_;

  FileDescriptor recorder_;
  Peer peer_;
  Stage stage_ = Stage::waiting;
  bool begun_ = false;       // the tap was asked to begin
  std::size_t buses_ = 0;    // whose names the recorder knows
  std::uint64_t ticks_ = 0;  // sent
  std::string out_;          // not sent yet
  std::size_t out_at_ = 0;
  std::int64_t moved_ns_ = 0;  // when it last took something, or had nothing to take
};

}  // namespace odomd::daemon
