// Where the car was: the last stretch that it drove, thinned for drawing.
#pragma once

#include <odom/types.h>

#include <cstddef>
#include <cstdint>
#include <deque>

namespace odomd::watch {

struct TrailPoint {
  double x = 0.0;  ///< [m], map frame
  double y = 0.0;
  bool joined = false;  ///< the car drove here from the point before; the pose did not leap
};

/// While the car stands nothing is added, so that the picture of the drive stays.
class Trail {
 public:
  static constexpr std::int64_t spacing_ns = 50'000'000;
  static constexpr double spacing_m = 0.005;
  static constexpr double leap_m = 0.5;
  static constexpr std::size_t longest = 600;  ///< points: half a minute of driving

  void take(const odom_pose& pose, std::uint64_t instance);

  [[nodiscard]] const std::deque<TrailPoint>& points() const { return points_; }
  /// Of the stretch, without the leaps [m].
  [[nodiscard]] double length() const;

 private:
  std::deque<TrailPoint> points_;
  std::uint64_t instance_ = 0;
  std::uint32_t resets_ = 0;
};

}  // namespace odomd::watch
