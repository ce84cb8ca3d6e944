// Looks at a daemon from outside: the shared memory by libodom, the rest by the status socket.
#pragma once

#include <cstdint>
#include <deque>
#include <odom/odom.hpp>
#include <optional>
#include <string>

#include "tools/live/watch/state.hpp"

namespace odomd::tools::watch {

/// Where the daemon is looked for.
struct Target {
  std::string segment;  ///< empty: that of the daemon at `socket`, else the library's defaults
  std::string socket;   ///< empty: the service's
};

enum class Depth : std::uint8_t { segment, segment_and_status };

/// One thread. Survives that there is no daemon, and its restarts.
class Observer {
 public:
  explicit Observer(Target target);

  /// Looks once, which takes a moment, and up to 0.3 s where the daemon is stopped. With
  /// Depth::segment the status remains that of an earlier look. Throws std::invalid_argument for a
  /// name or path that can never be one.
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
  const bool follows_socket_;  // its status names the segment
  State state_;
  std::optional<odom::Client> client_;
  std::int64_t trail_ns_ = 0;             // newest pose that the trail has taken
  std::deque<nlohmann::json> documents_;  // of the last seconds, the newest last
};

}  // namespace odomd::tools::watch
