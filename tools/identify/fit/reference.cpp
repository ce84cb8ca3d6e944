#include "tools/identify/fit/reference.hpp"

#include <Eigen/Core>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <vector>

#include "tools/identify/common/signal_log.hpp"

namespace odomd::tools::fitting {
namespace {

constexpr std::int64_t spacing_ns = 20'000'000;
constexpr double far_off = 3.0;      // in standard deviations
constexpr std::size_t fewest = 6;    // poses under a cubic
constexpr double both_sides = 0.25;  // of `half`: largest distance of a pose before and after

// The cubic's value at u = 0 for each of x, y and yaw: least squares, repeated with weights 1 / (1
// + (r / 3σ)²) from the residuals.
Eigen::Vector3d middle_of(std::span<const PoseSample> places, double t, double half) {
  const auto count = static_cast<Eigen::Index>(places.size());
  Eigen::MatrixX4d a(count, 4);
  Eigen::MatrixX3d b(count, 3);
  for (Eigen::Index i = 0; i < count; ++i) {
    const PoseSample& place = places[static_cast<std::size_t>(i)];
    const double u = (place.t - t) / half;
    a.row(i) << 1.0, u, u * u, u * u * u;
    b.row(i) << place.x, place.y, place.yaw;
  }
  const Eigen::MatrixX3d rest = b - a * a.householderQr().solve(b);
  Eigen::VectorXd weight(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const PoseSample& place = places[static_cast<std::size_t>(i)];
    const double off =
        std::hypot(rest(i, 0), rest(i, 1)) / std::hypot(place.sigma_x, place.sigma_y) +
        std::fabs(rest(i, 2)) / place.sigma_yaw;
    weight(i) = 1.0 / std::hypot(1.0, off / far_off);
  }
  const Eigen::MatrixX4d weighted = weight.asDiagonal() * a;
  const Eigen::MatrixX3d wanted = weight.asDiagonal() * b;
  return weighted.householderQr().solve(wanted).row(0);
}

}  // namespace

Trajectory smoothed(std::span<const estimator::CameraPose> poses, double half) {
  Trajectory result;
  result.name = "smoothed poses";
  if (poses.empty()) return result;
  const std::int64_t first = poses.front().capture_ns;
  const std::vector<PoseSample> places = in_order(poses, first);
  const auto last_ns = static_cast<std::int64_t>(1e9 * places.back().t);
  for (std::int64_t after = 0; after <= last_ns; after += spacing_ns) {
    const double t = 1e-9 * static_cast<double>(after);
    const auto begin = std::ranges::lower_bound(places, t - half, {}, &PoseSample::t);
    const auto end = std::ranges::upper_bound(places, t + half, {}, &PoseSample::t);
    const auto here = std::ranges::lower_bound(places, t, {}, &PoseSample::t);
    if (end - begin < static_cast<std::ptrdiff_t>(fewest) || here == end || here == begin) continue;
    if (here->t - t > both_sides * half || t - std::prev(here)->t > both_sides * half) continue;
    const Eigen::Vector3d now = middle_of({begin, end}, t, half);
    TrajectoryPoint point;
    point.t_ns = first + after;
    point.pose = {now(0), now(1), now(2)};
    result.points.push_back(point);
  }
  return result;
}

}  // namespace odomd::tools::fitting
