// The observed state of a daemon, and the last part of the car's path, thinned for drawing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include <odom/types.h>

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

}  // namespace odomd::tools::watch
