#include "tools/sim/course/track.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace odomd::sim {
namespace {

double distance(Vector2 a, Vector2 b) {
  return std::hypot(b.x - a.x, b.y - a.y);
}

// Points at equal distances along a polyline, including its ends. The polyline of a closed track
// ends at its start.
std::vector<Vector2> equidistant(const std::vector<Vector2>& line, std::size_t intervals) {
  std::vector<double> s(line.size(), 0.0);
  for (std::size_t i = 1; i < line.size(); ++i) s[i] = s[i - 1] + distance(line[i - 1], line[i]);
  std::vector<Vector2> result;
  result.reserve(intervals + 1);
  std::size_t i = 1;
  for (std::size_t k = 0; k < intervals; ++k) {
    const double wanted = s.back() * static_cast<double>(k) / static_cast<double>(intervals);
    while (i + 1 < s.size() && s[i] <= wanted) ++i;
    const double part = s[i] > s[i - 1] ? (wanted - s[i - 1]) / (s[i] - s[i - 1]) : 0.0;
    result.push_back({line[i - 1].x + part * (line[i].x - line[i - 1].x),
                      line[i - 1].y + part * (line[i].y - line[i - 1].y)});
  }
  result.push_back(line.back());
  return result;
}

// The point `i`; beyond the ends a closed track continues round, an open one straight on.
Vector2 beyond(const std::vector<Vector2>& line, Shape shape, std::ptrdiff_t i) {
  const auto last = static_cast<std::ptrdiff_t>(line.size()) - 1;
  const auto get = [&line](std::ptrdiff_t k) { return line[static_cast<std::size_t>(k)]; };
  if (shape == Shape::closed) return get(((i % last) + last) % last);
  if (i < 0) {
    const auto n = static_cast<double>(-i);
    return {get(0).x - n * (get(1).x - get(0).x), get(0).y - n * (get(1).y - get(0).y)};
  }
  if (i > last) {
    const auto n = static_cast<double>(i - last);
    return {get(last).x + n * (get(last).x - get(last - 1).x),
            get(last).y + n * (get(last).y - get(last - 1).y)};
  }
  return get(i);
}

// A moving average over 2 half + 1 samples.
std::vector<Vector2> smoothed(const std::vector<Vector2>& line, Shape shape, std::ptrdiff_t half) {
  std::vector<Vector2> result(line.size());
  for (std::size_t i = 0; i < line.size(); ++i) {
    Vector2 sum;
    for (std::ptrdiff_t k = -half; k <= half; ++k) {
      const Vector2 p = beyond(line, shape, static_cast<std::ptrdiff_t>(i) + k);
      sum.x += p.x;
      sum.y += p.y;
    }
    const auto count = static_cast<double>(2 * half + 1);
    result[i] = {sum.x / count, sum.y / count};
  }
  return result;
}

double length_of(const std::vector<Vector2>& line) {
  double sum = 0.0;
  for (std::size_t i = 1; i < line.size(); ++i) sum += distance(line[i - 1], line[i]);
  return sum;
}

constexpr double hill = 160.0;         // approximate distance between hilltops [m]
constexpr double full_bank_at = 45.0;  // a curve of this radius or less has the full bank [m]
constexpr double transition = 8.0;     // the bank is averaged over this distance on both sides [m]

double grade_at(const RoadProfile& profile, const Track& track, double s) {
  const double hills = std::max(1.0, std::round(track.length() / hill));
  const double part = s / track.length();
  // Two waves, one as long as the track; their sum stays within the grade.
  return profile.grade * (0.7 * std::sin(2.0 * std::numbers::pi * hills * part) +
                          0.3 * std::sin(2.0 * std::numbers::pi * part));
}

double bank_at(const RoadProfile& profile, const Track& track, double s) {
  double curvature = 0.0;
  for (const double offset : {-1.0, -0.5, 0.0, 0.5, 1.0})
    curvature += 0.2 * track.at(s + offset * transition).curvature;
  return -profile.bank * std::clamp(full_bank_at * curvature, -1.0, 1.0);
}

}  // namespace

Track::Track(const std::vector<Vector2>& points, Shape shape, double smoothing) : shape_(shape) {
  std::vector<Vector2> line = points;
  if (shape == Shape::closed && !line.empty()) line.push_back(line.front());
  const double length = length_of(line);
  const auto intervals = static_cast<std::size_t>(std::max(20.0, 20.0 * length / smoothing));
  line = equidistant(line, intervals);
  // Smoothed twice, so that the curvature is continuous and its slope bounded.
  for (int pass = 0; pass < 2; ++pass) line = smoothed(line, shape, 5);
  line = equidistant(line, intervals);

  step_ = length_of(line) / static_cast<double>(intervals);
  points_.reserve(line.size());
  double before = 0.0;
  for (std::size_t k = 0; k < line.size(); ++k) {
    const auto i = static_cast<std::ptrdiff_t>(k);
    const Vector2 a = beyond(line, shape, i - 1), b = line[k], c = beyond(line, shape, i + 1);
    double heading = std::atan2(c.y - a.y, c.x - a.x);
    if (k > 0) heading = before + std::remainder(heading - before, 2.0 * std::numbers::pi);
    before = heading;
    const double turn =
        std::remainder(std::atan2(c.y - b.y, c.x - b.x) - std::atan2(b.y - a.y, b.x - a.x),
                       2.0 * std::numbers::pi);
    points_.push_back({b.x, b.y, heading, turn / step_});
  }
}

TrackPoint Track::at(double s) const {
  const double whole = length();
  double turns = 0.0;
  if (shape_ == Shape::closed) {
    turns = std::floor(s / whole);
    s -= turns * whole;
  }
  const double inside = std::clamp(s, 0.0, whole);
  const std::size_t i = std::min(static_cast<std::size_t>(inside / step_), points_.size() - 2);
  const double part = inside / step_ - static_cast<double>(i);
  const TrackPoint &a = points_[i], &b = points_[i + 1];
  TrackPoint p{a.x + part * (b.x - a.x), a.y + part * (b.y - a.y),
               a.heading + part * (b.heading - a.heading),
               a.curvature + part * (b.curvature - a.curvature)};
  if (const double over = s - inside; over != 0.0) {
    p.x += over * std::cos(p.heading);
    p.y += over * std::sin(p.heading);
    p.curvature = 0.0;
  }
  p.heading += turns * (points_.back().heading - points_.front().heading);
  return p;
}

double Track::nearest(double x, double y, double s) const {
  for (int iteration = 0; iteration < 4; ++iteration) {
    const TrackPoint p = at(s);
    const double ahead = (x - p.x) * std::cos(p.heading) + (y - p.y) * std::sin(p.heading);
    s += std::clamp(ahead, -10.0 * step_, 10.0 * step_);
  }
  return s;
}

std::vector<Vector2> rounded_polygon(const std::vector<Corner>& corners, Shape shape,
                                     double spacing) {
  const std::size_t n = corners.size();
  std::vector<Vector2> line;
  for (std::size_t i = 0; i < n; ++i) {
    const Corner& c = corners[i];
    if (shape == Shape::open && (i == 0 || i + 1 == n)) {
      line.push_back({c.x, c.y});
      continue;
    }
    const Corner &a = corners[(i + n - 1) % n], &b = corners[(i + 1) % n];
    const double in = std::atan2(c.y - a.y, c.x - a.x), out = std::atan2(b.y - c.y, b.x - c.x);
    const double turn = std::remainder(out - in, 2.0 * std::numbers::pi);
    // The arc touches both sides at r tan(turn / 2) from the corner.
    const double tangent = c.radius * std::tan(0.5 * std::abs(turn));
    const Vector2 start{c.x - tangent * std::cos(in), c.y - tangent * std::sin(in)};
    const double side = turn < 0.0 ? -1.0 : 1.0;
    const auto pieces =
        static_cast<std::size_t>(std::ceil(c.radius * std::abs(turn) / spacing)) + 1;
    for (std::size_t k = 0; k <= pieces; ++k) {
      const double h = in + turn * static_cast<double>(k) / static_cast<double>(pieces);
      line.push_back({start.x + side * c.radius * (std::sin(h) - std::sin(in)),
                      start.y - side * c.radius * (std::cos(h) - std::cos(in))});
    }
  }
  return line;
}

RoadTilt tilt_at(const RoadProfile& profile, const Track& track, double s, double speed) {
  if (profile.is_level() || track.shape() == Shape::open) return {};
  constexpr double apart = 0.5;
  const double ahead = s + 0.5 * apart, behind = s - 0.5 * apart;
  const double along = speed / apart;
  return {
      .grade = std::atan(grade_at(profile, track, s)),
      .bank = bank_at(profile, track, s),
      .grade_rate = along * (grade_at(profile, track, ahead) - grade_at(profile, track, behind)),
      .bank_rate = along * (bank_at(profile, track, ahead) - bank_at(profile, track, behind))};
}

}  // namespace odomd::sim
