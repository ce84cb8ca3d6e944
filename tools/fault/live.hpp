// Applies faults between a car and its daemon: relays frames from one CAN interface to another, and
// camera poses from a new socket to the daemon's.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "can_protocol/dbc/dbc.hpp"
#include "can_protocol/sources/socketcan.hpp"
#include "daemon/core/config.hpp"
#include "daemon/sockets/local_socket.hpp"
#include "tools/fault/injector.hpp"
#include "tools/fault/stream_faults.hpp"
#include "tools/live/daemon_feeds.hpp"
#include "tools/sim/live.hpp"

namespace odomd::fault {

/// What a relay has received and forwarded.
struct Relayed {
  std::uint64_t received = 0;
  std::uint64_t sent = 0;
  std::uint64_t refused = 0;    ///< poses that found no daemon
  std::uint64_t malformed = 0;  ///< messages that are not poses
};

/// Relays frames from one interface to another.
class BusRelay {
 public:
  /// The faults' times count from `start_ns`. Throws like SocketCanSource, CanOutput and Injector,
  /// and std::invalid_argument if there is no interface `from`, or both interfaces are the same.
  BusRelay(const std::string& from, const std::string& to, const daemon::Config& config,
           std::span<const can::Database> databases, std::span<const Fault> faults,
           std::int64_t start_ns);

  /// Forwards received frames, and held-back frames that are due. Throws std::runtime_error if
  /// frames cannot be sent, or the interface `from` has disappeared.
  void pass_on(std::int64_t now_ns);

  [[nodiscard]] const Relayed& relayed() const noexcept { return relayed_; }
  [[nodiscard]] std::uint64_t lost() const noexcept { return source_->counters().lost.get(); }
  [[nodiscard]] std::vector<Acted> acted() const { return injector_->acted(); }

 private:
  std::unique_ptr<can::SocketCanSource> source_;
  sim::CanOutput output_;
  std::optional<Injector> injector_;
  std::vector<can::Frame> arrived_;
  std::vector<can::Frame> leaving_;
  std::int64_t maintained_ns_ = 0;
  Relayed relayed_;
};

/// Relays camera poses from a socket that it creates to the daemon's.
class CameraRelay {
 public:
  /// Waits `wait_s` seconds for the daemon. Throws like LocalSocket and CameraFeed.
  CameraRelay(const std::filesystem::path& from, const std::string& to, double wait_s,
              std::span<const Fault> faults, std::int64_t start_ns);

  void pass_on(std::int64_t now_ns);

  [[nodiscard]] const Relayed& relayed() const noexcept { return relayed_; }
  [[nodiscard]] std::vector<Acted> acted() const { return injector_.acted(); }

 private:
  void take(const odom_camera_message& message, std::int64_t now_ns);
  /// Returns false once the other end has closed.
  [[nodiscard]] bool read(int connection, std::int64_t now_ns);

  daemon::LocalSocket socket_;
  tools::CameraFeed feed_;
  CameraInjector injector_;
  std::vector<FileDescriptor> connections_;
  std::vector<estimator::CameraPose> leaving_;
  odom_clock clock_ = ODOM_CLOCK_MONOTONIC;  ///< of capture times, from the newest message
  Relayed relayed_;
};

}  // namespace odomd::fault
