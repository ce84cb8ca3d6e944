#include "tools/live/daemon_feeds.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <stdexcept>
#include <thread>

#include "base/wall_clock.hpp"

namespace odomd::tools {
namespace {

using std::chrono::nanoseconds;
using std::chrono::steady_clock;  // CLOCK_MONOTONIC here

constexpr const char* socket_name = "camera.sock";
constexpr std::int64_t admission_timeout_ns = 2'000'000'000;

steady_clock::time_point at_monotonic(std::int64_t ns) {
  return steady_clock::time_point{nanoseconds{ns}};
}

void send(CameraFeed& feed, const estimator::CameraPose& pose, odom_clock clock,
          PlayedLog& played) {
  ++(feed.send(pose, clock) ? played.sent : played.refused);
}

FileDescriptor connected(const std::string& path) {
  FileDescriptor connection = connect_to(path);
  if (!connection) fail_to_connect(path, errno, "record.sock");
  return connection;
}

FileDescriptor process_behind(const FileDescriptor& connection) {
  ucred peer{};
  socklen_t size = sizeof peer;
  if (::getsockopt(connection.get(), SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0) return {};
  return FileDescriptor{static_cast<int>(::syscall(SYS_pidfd_open, peer.pid, 0))};
}

}  // namespace

odom_camera_message camera_message(const estimator::CameraPose& pose, odom_clock clock) {
  return {.magic = ODOM_CAMERA_MAGIC,
          .version = ODOM_CAMERA_VERSION,
          .clock = static_cast<std::uint16_t>(clock),
          .sequence = 0,
          .capture_ns = pose.capture_ns,
          .x = pose.x,
          .y = pose.y,
          .yaw = pose.yaw,
          .sigma_x = pose.sigma_x,
          .sigma_y = pose.sigma_y,
          .sigma_yaw = pose.sigma_yaw,
          .reserved = 0};
}

CameraFeed::CameraFeed(const std::string& named, double wait_s, Admission admission)
    : admission_(admission) {
  const Waiting waiting{wait_s};
  while (true) {
    try {
      socket_ = socket_path(named, socket_name);
      const int error = sender_.open(socket_.c_str());
      if (error == 0) return;
      fail_to_connect(socket_, -error, socket_name);
    } catch (const NobodyThere&) {
      if (!waiting.goes_on()) throw;
    }
  }
}

bool CameraFeed::send(const estimator::CameraPose& pose, odom_clock clock) {
  const odom_camera_message message = camera_message(pose, clock);
  constexpr int attempts = 50;
  int error = 0;
  for (int attempt = 0; attempt < attempts; ++attempt) {
    error = sender_.send(message);
    if (error == 0) break;
    if (error != -EAGAIN && error != -ENOBUFS && error != -EINTR) break;
    std::this_thread::sleep_for(std::chrono::milliseconds{1});
  }
  // The library learns only later that the daemon refused a connection.
  if (error == 0 && !admitted_ && admission_ == Admission::awaited)
    error = sender_.flush(admission_timeout_ns);
  admitted_ = error == 0;
  if (admitted_) return true;
  if (error == -EBUSY || error == -EACCES) refusal_ = why_unconnected(socket_, -error, socket_name);
  if (error == -ENOENT || error == -ECONNREFUSED || error == -EPIPE || error == -ECONNRESET ||
      !refusal_.empty())
    return false;
  if (error == -EAGAIN)
    throw std::runtime_error(socket_ + ": the daemon does not take poses; is it stopped?");
  fail_to_connect(socket_, -error, socket_name);
}

PlayedLog play_with_daemon(CameraFeed& feed, odom::Client& client,
                           std::span<const estimator::CameraPose> poses, double wait_s) {
  // log clock - CLOCK_MONOTONIC; known once the daemon has released the first frame of its log.
  const auto offset = [&client] { return client.to_clock(ODOM_CLOCK_LOG, 0); };
  const Waiting waiting{wait_s, std::chrono::milliseconds{2}};
  while (!offset().has_value())
    if (!waiting.goes_on())
      throw std::runtime_error(
          "the daemon is not playing a log, so its clock cannot pace this one; give it --can LOG, "
          "wait longer with --wait, or use --from-now");

  // On a busy machine a daemon may be stale for a moment; one that has ended stays stale.
  const auto goes_on = [&offset] {
    for (int attempt = 0; attempt < 100; ++attempt) {
      const auto now = offset();
      if (now.has_value() && now.status != ODOM_STALE) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds{10});
    }
    return false;
  };

  // A pose that is overdue by less than this is still sent: the daemon checks its age.
  constexpr std::int64_t grace_ns = 200'000'000;
  PlayedLog played;
  for (const estimator::CameraPose& pose : poses) {
    if (!goes_on()) {
      played.daemon_ended = true;
      break;
    }
    const auto now = offset();
    const std::int64_t due_ns = pose.arrival_ns - *now;
    if (due_ns + grace_ns < monotonic_now()) {
      ++played.late;
      continue;
    }
    std::this_thread::sleep_until(at_monotonic(due_ns));
    send(feed, pose, ODOM_CLOCK_LOG, played);
  }
  return played;
}

PlayedLog play_from_now(CameraFeed& feed, std::span<const estimator::CameraPose> poses) {
  PlayedLog played;
  if (poses.empty()) return played;
  const std::int64_t shift_ns = monotonic_now() - poses.front().arrival_ns;
  for (estimator::CameraPose pose : poses) {
    pose.arrival_ns += shift_ns;
    pose.capture_ns += shift_ns;
    std::this_thread::sleep_until(at_monotonic(pose.arrival_ns));
    send(feed, pose, ODOM_CLOCK_MONOTONIC, played);
  }
  return played;
}

RecordingFeed::RecordingFeed(const std::filesystem::path& socket)
    : name_(socket.string()), connection_(connected(name_)), daemon_(process_behind(connection_)) {}

bool RecordingFeed::is_daemon_running() const {
  constexpr int ending_ms = 500;
  pollfd end{daemon_.get(), POLLIN, 0};
  return daemon_ && ::poll(&end, 1, ending_ms) == 0;
}

std::optional<RecordingFeed::Message> RecordingFeed::buffered() {
  daemon::RecordingHeader header;
  if (buffer_.size() - at_ < sizeof header) return std::nullopt;
  std::memcpy(&header, buffer_.data() + at_, sizeof header);
  if (header.size > daemon::longest_recording_message ||
      header.kind > daemon::RecordingMessage::refused) {
    throw std::runtime_error(name_ + ": the data is not a recording; is odomd listening there?");
  }
  if (buffer_.size() - at_ - sizeof header < header.size) return std::nullopt;
  const Message message{header.kind,
                        std::string_view{buffer_}.substr(at_ + sizeof header, header.size)};
  at_ += sizeof header + header.size;
  return message;
}

std::optional<RecordingFeed::Message> RecordingFeed::next(std::chrono::milliseconds timeout) {
  while (true) {
    if (auto message = buffered()) return message;
    buffer_.erase(0, at_);
    at_ = 0;
    if (ended_) return std::nullopt;

    pollfd readable{connection_.get(), POLLIN, 0};
    const int ready = ::poll(&readable, 1, static_cast<int>(timeout.count()));
    if (ready <= 0) return std::nullopt;
    std::array<char, 1U << 16U> piece;
    const ssize_t size = ::recv(connection_.get(), piece.data(), piece.size(), MSG_DONTWAIT);
    if (size < 0 && (errno == EAGAIN || errno == EINTR)) continue;
    if (size <= 0) {
      ended_ = true;
    } else {
      buffer_.append(piece.data(), static_cast<std::size_t>(size));
    }
  }
}

}  // namespace odomd::tools
