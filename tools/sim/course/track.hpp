// A line to drive along: closed or open, smooth, parametrised by arc length, with hills and banked
// turns.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tools/sim/car/chassis.hpp"

namespace odomd::sim {

/// A corner of a polygon, and the radius with which it is rounded.
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
  /// Passes through three or more dense points, smoothed over `smoothing` metres to avoid jumps of
  /// the curvature.
  Track(const std::vector<Vector2>& points, Shape shape, double smoothing);

  [[nodiscard]] Shape shape() const { return shape_; }
  [[nodiscard]] double length() const { return step_ * static_cast<double>(points_.size() - 1); }

  /// The point at arc length `s`. Beyond its ends, a closed track continues round and round (as
  /// does the heading), an open track straight on.
  [[nodiscard]] TrackPoint at(double s) const;

  /// Arc length of the foot of the perpendicular from a point, near the guess `s`.
  [[nodiscard]] double nearest(double x, double y, double s) const;

  /// Arc length between two samples of the track, and the samples.
  [[nodiscard]] double step() const { return step_; }
  [[nodiscard]] const std::vector<TrackPoint>& samples() const { return points_; }

 private:
  Shape shape_;
  double step_ = 0.0;
  std::vector<TrackPoint> points_;  // equidistant; on a closed track the last is the first again
};

/// Dense points along a polygon whose corners are rounded with arcs; the ends of an open polygon
/// stay. The arcs must fit.
[[nodiscard]] std::vector<Vector2> rounded_polygon(const std::vector<Corner>& corners, Shape shape,
                                                   double spacing);

/// Deviations of a road from level.
struct RoadProfile {
  double grade = 0.0;  ///< steepest [1]
  double bank = 0.0;   ///< largest, in its curves, with their outer side up [rad]

  [[nodiscard]] bool is_level() const { return grade == 0.0 && bank == 0.0; }
};

/// The road's tilt at arc length `s`, for a car that drives along it with `speed` [m/s]. A closed
/// track is level at its start and returns to its initial height; an open track is level
/// everywhere.
[[nodiscard]] RoadTilt tilt_at(const RoadProfile& profile, const Track& track, double s,
                               double speed);

}  // namespace odomd::sim
