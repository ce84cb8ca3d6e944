#include "tools/drive_files/trajectory.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/cli/csv.hpp"
#include "tools/cli/files.hpp"

namespace odomd::tools {
namespace {

enum Column : std::size_t {
  t,
  x,
  y,
  yaw,
  vx,
  vy,
  yaw_rate,
  sigma_x,
  sigma_y,
  sigma_yaw,
  cov_xy,
  cov_xyaw,
  cov_yyaw,
  reset_count
};

estimator::PoseCovariance covariance_at(const CsvReader& reader) {
  const auto sigma = [&reader](Column column) {
    const double value = reader.number(column);
    if (value < 0.0) reader.fail(column, "a standard deviation is negative; correct the line");
    return value;
  };
  const auto covariance = [&reader](Column column) {
    return reader.has(column) ? reader.number(column) : 0.0;
  };
  const double sx = sigma(sigma_x);
  const double sy = sigma(sigma_y);
  const double syaw = sigma(sigma_yaw);
  return {sx * sx, covariance(cov_xy),   covariance(cov_xyaw),
          sy * sy, covariance(cov_yyaw), syaw * syaw};
}

// The yaw nearest to the previous one.
double unwrapped(double angle, double before) {
  return before + std::remainder(angle - before, 2.0 * std::numbers::pi);
}

double mix(double a, double b, double share) {
  return a + share * (b - a);
}

}  // namespace

Trajectory read_trajectory(const std::filesystem::path& file, Frame frame) {
  auto input = open_input(file);
  return read_trajectory(input, file.string(), frame);
}

Trajectory read_trajectory(std::istream& input, const std::string& name, Frame frame) {
  const std::string prefix = frame == Frame::odom ? "odom_" : "";
  CsvReader reader{input,
                   name,
                   {"t", prefix + "x", prefix + "y", prefix + "yaw"},
                   {"vx", "vy", "yaw_rate", "sigma_x", "sigma_y", "sigma_yaw", "cov_xy", "cov_xyaw",
                    "cov_yyaw", "reset_count"}};
  Trajectory trajectory;
  trajectory.name = name;
  trajectory.has_motion = reader.has(vx) && reader.has(vy) && reader.has(yaw_rate);
  trajectory.has_covariance =
      frame == Frame::map && reader.has(sigma_x) && reader.has(sigma_y) && reader.has(sigma_yaw);

  const bool has_resets = frame == Frame::map && reader.has(reset_count);
  std::size_t repeated = 0;
  std::string first_repeated;
  while (reader.next()) {
    TrajectoryPoint point;
    point.t_ns = reader.time_ns(t);
    point.pose = {reader.number(x), reader.number(y), reader.number(yaw)};
    if (trajectory.has_motion) {
      point.motion = {reader.number(vx), reader.number(vy), reader.number(yaw_rate)};
    }
    if (trajectory.has_covariance) point.covariance = covariance_at(reader);
    if (has_resets) point.reset_count = reader.number(reset_count);
    if (!trajectory.points.empty()) {
      const TrajectoryPoint& before = trajectory.points.back();
      if (point.t_ns < before.t_ns) {
        reader.fail(t, "the time runs backwards; sort the rows by t");
      }
      if (point.t_ns == before.t_ns) {
        if (repeated++ == 0) first_repeated = reader.place();
        continue;
      }
      point.pose.yaw = unwrapped(point.pose.yaw, before.pose.yaw);
    }
    trajectory.points.push_back(point);
  }
  if (trajectory.points.empty()) {
    throw std::invalid_argument(name + ": has no rows");
  }
  append(trajectory.warnings, diagnostics::kind("file_content"), reader.warnings());
  if (repeated > 0) {
    trajectory.warnings.push_back(
        found(diagnostics::kind("file_content"), first_repeated,
              "column \"t\": a time is repeated (" + std::to_string(repeated) +
                  " rows in all); of rows with equal times the first is used"));
  }
  return trajectory;
}

TrajectoryPoint between(const TrajectoryPoint& a, const TrajectoryPoint& b, std::int64_t t_ns) {
  // Differences of times fit a double to the nanosecond; the times themselves need not.
  const double share = static_cast<double>(t_ns - a.t_ns) / static_cast<double>(b.t_ns - a.t_ns);
  TrajectoryPoint point;
  point.t_ns = t_ns;
  point.pose = {mix(a.pose.x, b.pose.x, share), mix(a.pose.y, b.pose.y, share),
                mix(a.pose.yaw, b.pose.yaw, share)};
  point.motion = {mix(a.motion.vx, b.motion.vx, share), mix(a.motion.vy, b.motion.vy, share),
                  mix(a.motion.yaw_rate, b.motion.yaw_rate, share)};
  for (std::size_t i = 0; i < point.covariance.size(); ++i) {
    point.covariance[i] = mix(a.covariance[i], b.covariance[i], share);
  }
  point.reset_count = b.reset_count;
  return point;
}

std::optional<TrajectoryPoint> at(const Trajectory& trajectory, std::int64_t t_ns) {
  const auto& points = trajectory.points;
  const auto after =
      std::lower_bound(points.begin(), points.end(), t_ns,
                       [](const TrajectoryPoint& p, std::int64_t time) { return p.t_ns < time; });
  if (after == points.end()) return std::nullopt;
  if (after->t_ns == t_ns) return *after;
  if (after == points.begin()) return std::nullopt;
  if (after->t_ns - (after - 1)->t_ns > trajectory.bridge_ns) return std::nullopt;
  return between(*(after - 1), *after, t_ns);
}

Trajectory cut_to(Trajectory trajectory, std::int64_t from_ns, std::int64_t to_ns) {
  const std::int64_t first_ns = trajectory.points.front().t_ns;
  const std::int64_t last_ns = trajectory.points.back().t_ns;
  std::erase_if(trajectory.points, [=](const TrajectoryPoint& point) {
    return point.t_ns < from_ns || point.t_ns > to_ns;
  });
  if (trajectory.points.empty()) {
    std::string text = trajectory.name + ": no row within --from and --to; its times are ";
    append_seconds(text, first_ns);
    text += " to ";
    append_seconds(text, last_ns);
    throw std::invalid_argument(text);
  }
  return trajectory;
}

}  // namespace odomd::tools
