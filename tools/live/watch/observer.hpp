// Observes a daemon from outside: the shared memory through libodom, the rest through its status.
#pragma once

#include <cstdint>
#include <deque>
#include <odom/odom.hpp>
#include <optional>
#include <string>

#include "tools/live/watch/state.hpp"

namespace odomd::tools::watch {

struct Target {
  std::string segment;  ///< empty: that of the daemon at `socket`, or the library's defaults
  std::string socket;   ///< empty: the service's
};

enum class Depth : std::uint8_t { segment, segment_and_status };

/// For use by one thread. Tolerates a missing daemon and restarts of the daemon.
class Observer {
 public:
  explicit Observer(Target target);

  /// Looks once. Takes a moment, up to 0.3 s if the daemon is stopped. With Depth::segment the
  /// status is that of an earlier look. Throws std::invalid_argument for an impossible name or
  /// path.
  void look(Depth depth = Depth::segment_and_status);

  /// The pose at a past time [ns, CLOCK_MONOTONIC], if it is in the segment's history.
  [[nodiscard]] std::optional<odom_pose> pose_at(std::int64_t time_ns);

  [[nodiscard]] const State& state() const { return state_; }

 private:
  void look_at_status();
  void follow_socket();
  void look_at_segment();
  void follow_trail(const odom_pose& pose, const odom_info& info);

  Target target_;
  const bool follows_socket_;  // the status from the socket names the segment
  State state_;
  std::optional<odom::Client> client_;
  std::int64_t trail_ns_ = 0;             // time of the newest pose in the trail
  std::deque<nlohmann::json> documents_;  // from the last seconds, oldest first
};

}  // namespace odomd::tools::watch
