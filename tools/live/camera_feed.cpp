#include "tools/live/camera_feed.hpp"

#include <cerrno>
#include <chrono>
#include <stdexcept>
#include <thread>

#include "base/wall_clock.hpp"
#include "tools/live/daemon_link.hpp"

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

}  // namespace odomd::tools
