#include "daemon/sockets/recorder_server.hpp"

#include <poll.h>
#include <sys/socket.h>

#include <cerrno>
#include <chrono>
#include <nlohmann/json.hpp>
#include <utility>

#include <fmt/format.h>

namespace odomd::daemon {
namespace {

/// The most bytes that are taken out of the rings before the socket accepts them.
constexpr std::size_t enough_bytes = 1U << 18U;
constexpr int accepts_per_turn = 16;
/// How long to wait at the end for a recorder that waits for its disk.
constexpr std::chrono::milliseconds timeout_at_end{500};
/// A recorder that reads nothing for this long is dropped.
constexpr std::int64_t timeout_ns = 10'000'000'000;

std::string refusal(const std::string& why) {
  const RecordingHeader header{RecordingMessage::refused, static_cast<std::uint32_t>(why.size())};
  return std::string(bytes_of(header)) + why;
}

}  // namespace

RecorderServer::RecorderServer(const Recorded& recorded, LocalSocket socket,
                               std::vector<RecordingFile> files)
    : recorded_(recorded), socket_(std::move(socket)), files_(std::move(files)) {}

void RecorderServer::accept(std::int64_t now_ns, Journal& journal) {
  for (int i = 0; i < accepts_per_turn; ++i) {
    auto connection = socket_.accept();
    if (!connection) return;
    if (recorder_) {
      const std::string text = refusal(fmt::format(
          "odomd is already being recorded (by pid {}); stop that recording", peer_.pid));
      static_cast<void>(::send(connection.get(), text.data(), text.size(), MSG_NOSIGNAL));
      continue;
    }
    recorder_ = std::move(connection);
    peer_ = peer_of(recorder_.get());
    stage_ = Stage::waiting;
    begun_ = false;
    buses_ = 0;
    ticks_ = 0;
    out_.clear();
    out_at_ = 0;
    moved_ns_ = now_ns;
    journal.info_counted(fmt::format("recording started (pid {}, uid {})", peer_.pid, peer_.uid));
  }
}

void RecorderServer::serve(std::int64_t now_ns, Journal& journal) {
  if (!recorder_) return;
  char nothing = 0;
  const ssize_t got = ::recv(recorder_.get(), &nothing, 1, MSG_DONTWAIT);
  if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR))
    return drop("the recorder disconnected", journal);

  const RecordingTap::State tap = recorded_.tap.state();
  if (!begun_ && tap == RecordingTap::State::idle) {
    recorded_.tap.begin();
    begun_ = true;
  } else if (begun_ && stage_ == Stage::waiting && tap != RecordingTap::State::wanted) {
    begin_stream();
  }
  // `tap` was read before the rings: if it is `full`, the beat adds nothing more to them.
  if (stage_ == Stage::streaming) {
    append_ticks();
    if (tap == RecordingTap::State::full && recorded_.tap.mark() == nullptr)
      end("the recorder did not keep up");
  }
  const std::size_t waiting = out_.size() - out_at_;
  if (!flush()) return drop("the recorder disconnected", journal);
  const std::size_t left = out_.size() - out_at_;
  if (stage_ == Stage::ended && left == 0) return drop("the recorder did not keep up", journal);
  // Once the rings were full, one timeout applies to all that is left: progress does not extend it.
  const bool fell_behind = tap == RecordingTap::State::full;
  if (!fell_behind && (left == 0 || left < waiting)) moved_ns_ = now_ns;
  if (now_ns - moved_ns_ < timeout_ns) return;
  drop(fell_behind ? "the recorder did not keep up" : "the recorder read nothing for 10 s",
       journal);
}

void RecorderServer::close(Journal& journal) {
  if (!recorder_) return;
  if (stage_ == Stage::streaming) {
    // No more than the rings hold, since the beat still runs at this point.
    for (std::size_t i = 0; i < RecordingTap::max_ticks && recorded_.tap.mark() != nullptr; ++i)
      append_tick();
    end("odomd has ended");
  }
  flush_until_timeout();
  drop("odomd ends", journal);
}

void RecorderServer::begin_stream() {
  append(RecordingMessage::hello, hello());
  for (const auto& file : files_) {
    std::string bytes = file.name;
    bytes += '\0';
    append(RecordingMessage::file, bytes += file.text);
  }
  send_buses();
  append(RecordingMessage::state, checkpoint_bytes(recorded_.tap.checkpoint()));
  stage_ = Stage::streaming;
}

std::string RecorderServer::hello() const {
  const Config& config = recorded_.config;
  const nlohmann::ordered_json json{{"build", build_identity()},
                                    {"version", ODOMD_VERSION},
                                    {"instance", fmt::format("{:016x}", recorded_.instance_id)},
                                    {"config", config.file.string()},
                                    {"model", name_of(config.model)},
                                    {"period_ns", config.realtime.period_ns},
                                    {"camera_expected", config.camera.configured},
                                    {"sources", config.can.sources}};
  return json.dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace);
}

void RecorderServer::send_buses() {
  const auto names = recorded_.buses.all();
  if (names.size() == buses_) return;
  buses_ = names.size();
  std::string text;
  for (const auto& name : names) text += name + '\n';
  append(RecordingMessage::buses, text);
}

void RecorderServer::append_ticks() {
  while (recorded_.tap.mark() != nullptr && out_.size() - out_at_ < enough_bytes) append_tick();
}

void RecorderServer::append_tick() {
  send_buses();  // before the frames of a new bus
  RecordingTap& tap = recorded_.tap;
  const TickMark mark = *tap.mark();
  const std::size_t size =
      sizeof mark + mark.frames * sizeof(can::Frame) + mark.cameras * sizeof(estimator::CameraPose);
  out_ += bytes_of(RecordingHeader{RecordingMessage::tick, static_cast<std::uint32_t>(size)});
  out_ += bytes_of(mark);
  for (std::uint32_t i = 0; i < mark.frames; ++i) out_ += bytes_of(tap.take_frame());
  for (std::uint32_t i = 0; i < mark.cameras; ++i) out_ += bytes_of(tap.take_camera());
  tap.pop_mark();
  ++ticks_;
}

void RecorderServer::append(RecordingMessage kind, std::string_view bytes) {
  out_ += bytes_of(RecordingHeader{kind, static_cast<std::uint32_t>(bytes.size())});
  out_ += bytes;
}

bool RecorderServer::flush() {
  while (out_at_ < out_.size()) {
    const ssize_t sent = ::send(recorder_.get(), out_.data() + out_at_, out_.size() - out_at_,
                                MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0) {
      const bool later = errno == EAGAIN;
      // Drop the bytes that a slow recorder has read already.
      out_.erase(0, out_at_);
      out_at_ = 0;
      return later;
    }
    out_at_ += static_cast<std::size_t>(sent);
  }
  out_.clear();
  out_at_ = 0;
  return true;
}

void RecorderServer::flush_until_timeout() {
  using std::chrono::steady_clock;
  const auto deadline = steady_clock::now() + timeout_at_end;
  while (flush() && !out_.empty()) {
    const auto rest = std::chrono::ceil<std::chrono::milliseconds>(deadline - steady_clock::now());
    if (rest.count() <= 0) return;
    pollfd room{recorder_.get(), POLLOUT, 0};
    ::poll(&room, 1, static_cast<int>(rest.count()));
  }
}

void RecorderServer::end(std::string_view why) {
  append(RecordingMessage::end, why);
  stage_ = Stage::ended;
}

void RecorderServer::drop(std::string_view why, Journal& journal) {
  journal.info_counted(
      fmt::format("recording (pid {}) ended after {} ticks: {}", peer_.pid, ticks_, why));
  recorder_ = {};
  recorded_.tap.end();
}

}  // namespace odomd::daemon
