// Cameras and a recorder act on their sockets arbitrarily. Poses and warnings together must not
// outnumber the messages sent, and the recorder must get only complete messages.
//
// The input consists of commands of one byte: a camera connects (0), disconnects (1), sends raw
// bytes (2: one byte for their number, then the bytes), or sends a message with correct magic and
// version (3: the rest of it); a recorder connects (4), disconnects (5), sends bytes (6: as for a
// camera), or reads (7: two bytes, the maximum length); all others are a tick and a turn of
// housekeeping. The upper half of a command selects the camera.
#include <sys/socket.h>

#include <array>
#include <cstddef>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "daemon/sockets/camera_server.hpp"
#include "daemon/sockets/recorder_server.hpp"
#include "tests/fuzz/bare_car.hpp"
#include "tests/scratch.hpp"
#include "tests/unix_socket.hpp"

namespace odomd::fuzz {
namespace {

using daemon::CameraServer;

const Scratch& directory() {
  static const Scratch made;
  return made;
}

/// Reads a number, and that many bytes, or fewer at the end of the input.
std::vector<std::uint8_t> some_bytes(Input& input) {
  std::vector<std::uint8_t> bytes;
  for (std::size_t left = input.take<std::uint8_t>(); left > 0 && !input.empty(); --left)
    bytes.push_back(input.take<std::uint8_t>());
  return bytes;
}

class Cameras {
 public:
  void connect(std::size_t which) {
    std::array<int, 2> ends{};
    require(
        ::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends.data()) == 0,
        "socketpair");
    ends_.at(which) = FileDescriptor(ends[0]);
    static_cast<void>(server_.admit(FileDescriptor(ends[1]), {1, 2}, 77));
  }
  void end(std::size_t which) { ends_.at(which) = FileDescriptor(); }

  void send(std::size_t which, const void* bytes, std::size_t size) {
    if (!ends_.at(which)) return;
    if (::send(ends_.at(which).get(), bytes, size, MSG_NOSIGNAL | MSG_DONTWAIT) >= 0) ++sent_;
  }

  void tick(std::int64_t now_ns) {
    const auto drained = server_.drain(poses_, {wall_, start_ns / 2}, now_ns, *events_);
    require(drained.poses + drained.malformed <= CameraServer::max_poses, "a drain is bounded");
    for (std::size_t i = 0; i < drained.poses; ++i)
      require(poses_.at(i).arrival_ns == now_ns, "a pose arrives when it is read");
    read_ += drained.poses + drained.malformed;
    require(read_ <= sent_, "no message is read twice");
    while (const auto event = events_->next())
      if (event->kind == daemon::EventKind::camera_malformed)
        require(event->a > 0 && event->a < static_cast<std::int64_t>(daemon::MalformedCause::count),
                "a warning has a text");
    require(events_->dropped() == 0, "a tick's events find room");
    for (const auto& connection : server_.connections())
      require(connection.malformed <= connection.messages, "what is malformed is a message");
    server_.close_ended(77);
  }

 private:
  CameraServer server_;
  WallClock wall_ = wall_clock();
  std::array<FileDescriptor, 2 * CameraServer::max_connections> ends_;
  std::array<estimator::CameraPose, CameraServer::max_poses> poses_{};
  std::unique_ptr<daemon::EventRing> events_ = std::make_unique<daemon::EventRing>();
  std::uint64_t sent_ = 0;
  std::uint64_t read_ = 0;
};

class Recording {
 public:
  Recording()
      : config_(config(estimator::Model::full)),
        pipeline_(pipeline_of(config_, true)),
        tap_(std::make_unique<daemon::RecordingTap>(*pipeline_)),
        journal_({directory().path("log"), "error"}),
        server_(
            {config_, buses_, 1, *tap_},
            daemon::LocalSocket({{directory().path("socket"), 0600}, daemon::SocketType::stream}),
            {{"car.toml", "# a car\n"}}) {
    static_cast<void>(buses_.index_of("can0"));
  }

  void connect() {
    // If too many connections are waiting, this one is refused and its bytes are lost.
    recorder_ = connected_socket(directory().path("socket"), SOCK_STREAM | SOCK_NONBLOCK);
    got_.clear();
  }
  void end() { recorder_ = FileDescriptor(); }
  void send(const std::vector<std::uint8_t>& bytes) const {
    if (recorder_)
      static_cast<void>(
          ::send(recorder_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT));
  }
  void read(std::size_t most) {
    if (!recorder_) return;
    std::vector<char> piece(most);
    const ssize_t size = ::recv(recorder_.get(), piece.data(), piece.size(), MSG_DONTWAIT);
    if (size <= 0) return;
    got_.append(piece.data(), static_cast<std::size_t>(size));
    check_messages();
  }

  void tick(std::uint64_t number, std::int64_t now_ns) {
    tap_->tick_done(pipeline_->tick(number, now_ns), {now_ns, 0, 0}, *pipeline_);
    server_.accept(now_ns, journal_);
    server_.serve(now_ns, journal_);
  }

 private:
  /// Removes complete messages from the front of the received bytes.
  void check_messages() {
    daemon::RecordingHeader header;
    std::size_t at = 0;
    for (; got_.size() - at >= sizeof header; at += sizeof header + header.size) {
      std::memcpy(&header, got_.data() + at, sizeof header);
      require(header.kind <= daemon::RecordingMessage::refused, "a message has a kind");
      require(header.size <= daemon::longest_recording_message, "a message is no longer");
      if (got_.size() - at - sizeof header < header.size) break;
    }
    got_.erase(0, at);
  }

  daemon::Config config_;
  can::BusNames buses_;
  std::unique_ptr<daemon::Pipeline> pipeline_;
  std::unique_ptr<daemon::RecordingTap> tap_;
  daemon::Journal journal_;
  daemon::RecorderServer server_;
  FileDescriptor recorder_;
  std::string got_;
};

void run(Input input) {
  Cameras cameras;
  Recording recording;
  std::uint64_t number = 1;
  std::int64_t now = start_ns;
  while (!input.empty()) {
    const auto command = input.take<std::uint8_t>();
    const std::size_t which = (command >> 4U) % (2 * CameraServer::max_connections);
    switch (command & 15U) {
      case 0:
        cameras.connect(which);
        break;
      case 1:
        cameras.end(which);
        break;
      case 2: {
        const auto bytes = some_bytes(input);
        cameras.send(which, bytes.data(), bytes.size());
        break;
      }
      case 3: {
        auto message = input.take<odom_camera_message>();
        message.magic = ODOM_CAMERA_MAGIC;
        message.version = ODOM_CAMERA_VERSION;
        cameras.send(which, &message, sizeof message);
        break;
      }
      case 4:
        recording.connect();
        break;
      case 5:
        recording.end();
        break;
      case 6:
        recording.send(some_bytes(input));
        break;
      case 7:
        recording.read(input.take<std::uint16_t>());
        break;
      default:
        now += period_ns;
        cameras.tick(now);
        recording.tick(number++, now);
    }
  }
}

}  // namespace
}  // namespace odomd::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  odomd::fuzz::run({data, size});
  return 0;
}
