// Observes a daemon from outside: the shared memory through libodom, the rest through its status.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <utility>

#include <odom/odom.hpp>

#include "tools/live/status_value.hpp"

namespace odomd::tools::watch {

struct TrailPoint {
  double x = 0.0;  ///< [m], map frame
  double y = 0.0;
  bool joined = false;  ///< the car drove here from the previous point; the pose did not jump
};

/// Adds nothing while the car is stationary, so that the picture of the drive stays.
class Trail {
 public:
  static constexpr std::int64_t spacing_ns = 50'000'000;
  static constexpr double spacing_m = 0.005;
  static constexpr double leap_m = 0.5;
  static constexpr std::size_t longest = 600;  ///< points: half a minute of driving

  void take(const odom_pose& pose, std::uint64_t instance);

  [[nodiscard]] const std::deque<TrailPoint>& points() const { return points_; }

 private:
  std::deque<TrailPoint> points_;
  std::uint64_t instance_ = 0;
  std::uint32_t resets_ = 0;
};

/// The content of the shared memory.
struct Segment {
  odom_pose pose{};
  odom_details details{};
  odom_info info{};
  odom_beat beat{};
  bool silent = false;  ///< the daemon has not ticked for four periods; this is its last state
};

struct State {
  std::int64_t now_ns = 0;  ///< CLOCK_MONOTONIC

  std::string segment_name;        ///< as requested
  std::optional<Segment> segment;  ///< absent: never attached, or nothing published yet
  std::string segment_problem;     ///< why `segment` is absent; empty if `status` is absent too
  Trail trail;

  std::string socket;
  std::optional<Json> status;  ///< the newest document, absent while nobody answers
  std::optional<Json> before;  ///< one some seconds earlier, for rates
  std::string status_problem;  ///< why `status` is absent

  std::uint64_t restarts = 0;  ///< times another daemon took over while we watched

  /// The status, with its rates; nothing while nobody answers.
  [[nodiscard]] StatusValue reported() const {
    return status ? StatusValue{*status, before} : StatusValue{};
  }
};

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
  std::int64_t trail_ns_ = 0;                            // time of the newest pose in the trail
  std::deque<std::pair<std::int64_t, Json>> documents_;  // of the last seconds, with their times
};

}  // namespace odomd::tools::watch
