#include "tools/evaluation/evaluation_checks.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tools/math/se2.hpp"

namespace odomd::tools {
namespace {

constexpr std::int64_t step_ns = 10'000'000;
constexpr std::int64_t steps = 25;  // in each direction
constexpr double step_s = 0.01;
constexpr std::int64_t window_ns = 1'000'000'000;
constexpr std::int64_t stride_ns = 50'000'000;
constexpr std::size_t most_samples = 2000;
constexpr std::size_t fewest = 100;

// Smaller offsets may come from a latency that is not configured, or from values that are held
// between two samples.
constexpr double least_offset = 0.02;  // s
// Largest share of the error that may remain without the offset. Recorded and simulated drives with
// correct times have 0.75 and above, those 50 ms off 0.5 and below.
constexpr double left_of_position = 0.6;
constexpr double left_of_heading = 0.95;
// The same for errors over a second: a kinematic model, which turns with the steering, has 0.65 and
// above.
constexpr double left_of_turn = 0.5;
constexpr double left_of_way = 0.9;
constexpr double least_turn = 0.005;  // rad in a second, rms of the error

// Mean squares of an error, one for each removed offset.
class Scan {
 public:
  void add(double sum, double count) { squares_.push_back(count > 0.0 ? sum / count : 0.0); }

  [[nodiscard]] double as_it_is() const { return std::sqrt(squares_[steps]); }
  [[nodiscard]] double least() const { return std::sqrt(squares_[best()]); }
  [[nodiscard]] double left() const { return as_it_is() > 0.0 ? least() / as_it_is() : 1.0; }
  [[nodiscard]] bool is_inside() const { return best() > 1 && best() + 2 < squares_.size(); }
  /// The vertex of the parabola through the minimum and its neighbours; only if is_inside().
  [[nodiscard]] double offset() const {
    const std::size_t k = best();
    const double bend = squares_[k - 1] - 2.0 * squares_[k] + squares_[k + 1];
    const double fraction = bend > 0.0 ? 0.5 * (squares_[k - 1] - squares_[k + 1]) / bend : 0.0;
    return step_s * (static_cast<double>(k) - static_cast<double>(steps) + fraction);
  }

 private:
  [[nodiscard]] std::size_t best() const {
    return static_cast<std::size_t>(std::ranges::min_element(squares_) - squares_.begin());
  }

  std::vector<double> squares_;
};

struct TimeRange {
  std::int64_t from = 0;
  std::int64_t to = 0;
};

// The range of times that can be evaluated for every offset.
TimeRange judged(const Trajectory& reference, const Trajectory& estimate) {
  constexpr std::int64_t margin_ns = steps * step_ns;
  return {std::max(reference.points.front().t_ns + margin_ns, estimate.points.front().t_ns),
          std::min(reference.points.back().t_ns - margin_ns, estimate.points.back().t_ns)};
}

std::vector<TrajectoryPoint> thinned(const Trajectory& estimate, const TimeRange& span) {
  std::vector<TrajectoryPoint> all;
  for (const TrajectoryPoint& point : estimate.points)
    if (point.t_ns >= span.from && point.t_ns <= span.to) all.push_back(point);
  const std::size_t every = all.size() / most_samples + 1;
  std::vector<TrajectoryPoint> some;
  for (std::size_t i = 0; i < all.size(); i += every) some.push_back(all[i]);
  return some;
}

// The row at half of the path: a stationary car gives no information about times.
std::size_t half_of_the_way(const std::vector<TrajectoryPoint>& points) {
  std::vector<double> driven{0.0};
  for (std::size_t i = 1; i < points.size(); ++i)
    driven.push_back(driven.back() + distance(points[i - 1].pose, points[i].pose));
  return static_cast<std::size_t>(std::ranges::lower_bound(driven, 0.5 * driven.back()) -
                                  driven.begin());
}

double squared(double value) {
  return value * value;
}

/// Whether the reference is known at a time and at all offsets from it (a camera's has gaps).
bool is_known_around(const Trajectory& reference, std::int64_t t_ns) {
  for (std::int64_t k = -steps; k <= steps; ++k)
    if (!at(reference, t_ns + k * step_ns)) return false;
  return true;
}

}  // namespace

std::optional<TimeOffset> offset_by_positions(const Trajectory& reference,
                                              const Trajectory& estimate, Align align) {
  std::vector<TrajectoryPoint> points = thinned(estimate, judged(reference, estimate));
  std::erase_if(points, [&reference](const TrajectoryPoint& point) {
    return !is_known_around(reference, point.t_ns);
  });
  if (points.size() < fewest) return std::nullopt;
  const std::size_t half = half_of_the_way(points);
  Scan position, first_half, second_half, heading;
  for (std::int64_t k = -steps; k <= steps; ++k) {
    std::vector<Pair> pairs;
    pairs.reserve(points.size());
    for (const TrajectoryPoint& point : points)
      pairs.push_back({point, *at(reference, point.t_ns + k * step_ns)});
    double first = 0.0, second = 0.0, turn = 0.0;
    const auto errors = pose_errors(pairs, alignment(pairs, align), false);
    for (std::size_t i = 0; i < errors.size(); ++i) {
      const estimator::Pose2& e = errors[i].error;
      (i < half ? first : second) += squared(e.x) + squared(e.y);
      turn += squared(e.yaw);
    }
    const auto count = static_cast<double>(points.size());
    position.add(first + second, count);
    first_half.add(first, static_cast<double>(half));
    second_half.add(second, count - static_cast<double>(half));
    heading.add(turn, count);
  }
  if (position.left() > left_of_position || heading.left() > left_of_heading) return std::nullopt;
  if (!position.is_inside() || !heading.is_inside() || !first_half.is_inside() ||
      !second_half.is_inside())
    return std::nullopt;
  const double late = position.offset();
  if (std::fabs(late) < least_offset) return std::nullopt;
  // An unstated lever arm shifts positions like an offset, but not headings.
  if (std::fabs(heading.offset() - late) > 0.03) return std::nullopt;
  // An error that grows with the path (a wheel's scale, a gyro's bias) would need an increasing
  // offset.
  if (std::fabs(first_half.offset() - second_half.offset()) >
      std::max(0.015, 0.3 * std::fabs(late)))
    return std::nullopt;
  return TimeOffset{late, position.as_it_is(), position.least()};
}

std::optional<TimeOffset> offset_by_motion(const Trajectory& reference,
                                           const Trajectory& estimate) {
  const TimeRange span = judged(reference, estimate);
  const std::int64_t begins = span.to - window_ns - span.from;
  const std::int64_t stride =
      std::max(stride_ns, begins / static_cast<std::int64_t>(most_samples) + 1);
  struct Window {
    std::int64_t begin_ns = 0;
    estimator::Pose2 moved;
  };
  std::vector<Window> windows;
  for (std::int64_t t = span.from; t <= span.to - window_ns; t += stride) {
    const auto from = at(estimate, t), to = at(estimate, t + window_ns);
    if (!from || !to || from->reset_count != to->reset_count) continue;
    if (!is_known_around(reference, t) || !is_known_around(reference, t + window_ns)) continue;
    windows.push_back({t, relative(from->pose, to->pose)});
  }
  if (windows.size() < fewest) return std::nullopt;
  Scan way, turn;
  for (std::int64_t k = -steps; k <= steps; ++k) {
    double ways = 0.0, turns = 0.0;
    for (const Window& window : windows) {
      const std::int64_t begin = window.begin_ns + k * step_ns;
      const estimator::Pose2 moved =
          relative(at(reference, begin)->pose, at(reference, begin + window_ns)->pose);
      ways += squared(window.moved.x - moved.x) + squared(window.moved.y - moved.y);
      turns += squared(window.moved.yaw - moved.yaw);
    }
    const auto count = static_cast<double>(windows.size());
    way.add(ways, count);
    turn.add(turns, count);
  }
  if (turn.as_it_is() < least_turn || turn.left() > left_of_turn || way.left() > left_of_way)
    return std::nullopt;
  if (!turn.is_inside() || !way.is_inside()) return std::nullopt;
  const double late = turn.offset();
  if (std::fabs(late) < least_offset || std::fabs(way.offset() - late) > 0.02) return std::nullopt;
  return TimeOffset{late, way.as_it_is(), way.least()};
}

}  // namespace odomd::tools
