// A line to drive along: closed or open, smooth, parametrised by arc length, with hills and banked
// turns.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tools/sim/car/chassis.hpp"

namespace odomd::sim {

struct Point {
  double x = 0.0, y = 0.0;  ///< [m]
};

/// A corner of a polygon and the radius it is rounded with.
struct Corner {
  double x = 0.0, y = 0.0, radius = 0.0;  ///< [m]
};

struct TrackPoint {
  double x = 0.0, y = 0.0;  ///< [m]
  double heading = 0.0;     ///< of the tangent [rad], continuous along the track
  double curvature = 0.0;   ///< positive to the left [1/m]
};

enum class Shape : std::uint8_t { open, closed };

class Track {
 public:
  /// Through dense points, smoothed over `smoothing` metres so that the curvature has no jumps.
  /// Throws std::invalid_argument for fewer than three points or a length of zero.
  Track(const std::vector<Point>& points, Shape shape, double smoothing);

  [[nodiscard]] Shape shape() const { return shape_; }
  [[nodiscard]] double length() const { return step_ * static_cast<double>(points_.size() - 1); }

  /// At arc length `s`: a closed track goes on round and round (the heading too), an open one goes
  /// straight on beyond its ends.
  [[nodiscard]] TrackPoint at(double s) const;

  /// Arc length of the foot of the perpendicular from a point, near the guess `s`.
  [[nodiscard]] double nearest(double x, double y, double s) const;

  /// Arc length between two samples of the track, and how many there are.
  [[nodiscard]] double step() const { return step_; }
  [[nodiscard]] const std::vector<TrackPoint>& samples() const { return points_; }

 private:
  Shape shape_;
  double step_ = 0.0;
  std::vector<TrackPoint> points_;  // equidistant; of a closed track the last is the first again
};

/// Dense points along a polygon whose corners are rounded by arcs; corners of an open one must not
/// be its ends. Throws std::invalid_argument where there are none or their arcs do not fit.
[[nodiscard]] std::vector<Point> rounded_polygon(const std::vector<Corner>& corners, Shape shape,
                                                 double spacing);

/// How far a road departs from a level one.
struct RoadProfile {
  double grade = 0.0;  ///< steepest [1]
  double bank = 0.0;   ///< most, in its curves, their outer side up [rad]

  [[nodiscard]] bool is_level() const { return grade == 0.0 && bank == 0.0; }
};

/// At arc length `s` of a closed track, for a car that goes along it with `speed` [m/s]. Ends where
/// it began in height; level at its start, and all of it where a track is open.
[[nodiscard]] RoadTilt tilt_at(const RoadProfile& profile, const Track& track, double s,
                               double speed);

}  // namespace odomd::sim
