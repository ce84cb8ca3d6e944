// The tests' own daemon: its segment, which ticks on request, and its sockets.
#pragma once

#include <sys/socket.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include <odom/types.h>

#include "base/file_descriptor.hpp"
#include "shm_api/writer.hpp"
#include "tests/unix_socket.hpp"

namespace odomd::tools {

inline std::int64_t now_ns() {
  return std::chrono::nanoseconds{std::chrono::steady_clock::now().time_since_epoch()}.count();
}

/// CLOCK_REALTIME - CLOCK_MONOTONIC in these segments.
inline constexpr std::int64_t realtime_offset_ns = 1'700'000'000'123'456'789;

/// A daemon with a period of a second: its pose is fresh for four seconds after a tick, so that
/// slow tests pass.
class SlowDaemon {
 public:
  explicit SlowDaemon(const std::string& segment, std::int64_t period_ns = 1'000'000'000,
                      std::uint64_t slots = 4096)
      : period_ns_(period_ns) {
    odom_info info{};
    info.period_ns = period_ns;
    info.realtime_offset_ns = realtime_offset_ns;
    info.first_tick_ns = first_ns_;
    writer_ = std::make_unique<shm::Writer>(
        shm::SegmentSettings{.name = segment, .slots = slots, .group = {}}, info);
    writer_->set_first_tick(first_ns_);
    writer_->set_realtime_offset(realtime_offset_ns);
    pose.mode = ODOM_TRACKING;
  }

  /// Publishes `pose` and `details` as the next tick.
  void tick() {
    ++pose.tick;
    pose.time_ns = time_of(pose.tick);
    writer_->publish(pose, details);
    writer_->set_heartbeat(now_ns());
    writer_->wake_clients();
  }

  /// Publishes the tick with this number.
  void tick(std::uint64_t number) {
    pose.tick = number - 1;
    tick();
  }

  /// Sets the heartbeat without a tick.
  void beat() { writer_->set_heartbeat(now_ns()); }
  void fall_silent() { writer_->set_heartbeat(now_ns() - 60 * period_ns_); }
  /// Sets the present time of the log that the daemon plays.
  void play_log(std::int64_t log_ns) {
    beat();
    writer_->set_log_offset(log_ns - now_ns());
  }

  [[nodiscard]] std::int64_t time_of(std::uint64_t tick) const {
    return first_ns_ + static_cast<std::int64_t>(tick) * period_ns_;
  }

  odom_pose pose{};
  odom_details details{};

 private:
  std::int64_t period_ns_;
  std::int64_t first_ns_ = now_ns();
  std::unique_ptr<shm::Writer> writer_;
};

/// Sends the text to each client that connects, as the daemon does.
class AnsweringSocket {
 public:
  AnsweringSocket(const std::string& path, std::string text)
      : socket_(listening_socket(path, SOCK_STREAM)) {
    thread_ = std::thread{[this, text = std::move(text)] {
      while (true) {
        const int accepted = ::accept(socket_.get(), nullptr, nullptr);
        if (accepted < 0) return;  // shut down
        const FileDescriptor connection{accepted};
        (void)::send(connection.get(), text.data(), text.size(), MSG_NOSIGNAL);
      }
    }};
  }
  ~AnsweringSocket() {
    ::shutdown(socket_.get(), SHUT_RDWR);
    thread_.join();
  }
  AnsweringSocket(const AnsweringSocket&) = delete;
  AnsweringSocket& operator=(const AnsweringSocket&) = delete;

 private:
  FileDescriptor socket_;
  std::thread thread_;
};

}  // namespace odomd::tools
