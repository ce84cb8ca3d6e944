#include "tools/drive_files/trajectory.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/cli/files.hpp"
#include "tools/drive_files/table.hpp"

namespace odomd::tools {
namespace {

// Indices of the first column of the motion, and of the columns that only a pose in the map has.
constexpr std::size_t first_motion = 4, first_sigma = 7;

// The file contains the square roots of the variances.
constexpr auto map_columns = [](auto&& cell, auto& point) {
  point_columns(cell, point);
  auto& [xx, xy, xyaw, yy, yyaw, yawyaw] = point.covariance;
  cell("sigma_x", xx);
  cell("sigma_y", yy);
  cell("sigma_yaw", yawyaw);
  cell("cov_xy", xy);
  cell("cov_xyaw", xyaw);
  cell("cov_yyaw", yyaw);
  cell("reset_count", point.reset_count);
};

void square(double& value, const CsvReader& reader, std::size_t column) {
  if (value < 0.0) reader.fail(column, "a standard deviation is negative; correct the line");
  value *= value;
}

// The angle plus whole turns, so that it is within half a turn of `before`.
double unwrapped(double angle, double before) {
  return before + std::remainder(angle - before, 2.0 * std::numbers::pi);
}

double mix(double a, double b, double share) {
  return a + share * (b - a);
}

}  // namespace

Trajectory read_trajectory(const std::filesystem::path& file, Frame frame,
                           const std::vector<std::string>& further) {
  auto input = open_input(file);
  return read_trajectory(input, file.string(), frame, further);
}

Trajectory read_trajectory(std::istream& input, const std::string& name, Frame frame,
                           const std::vector<std::string>& further) {
  std::vector<std::string> names = names_of<TrajectoryPoint>(map_columns);
  if (frame == Frame::odom) {
    names.resize(first_sigma);
    for (std::size_t i = 1; i < first_motion; ++i) names[i].insert(0, "odom_");
  }
  const std::size_t first_further = names.size();
  names.insert(names.end(), further.begin(), further.end());
  CsvReader reader{input, name, names, LastLine::keep_whole, {.required = first_motion}};
  const auto has_all = [&](std::size_t first) {
    return reader.has(first) && reader.has(first + 1) && reader.has(first + 2);
  };
  Trajectory trajectory;
  trajectory.name = name;
  trajectory.columns.resize(further.size());
  trajectory.has_motion = has_all(first_motion);
  trajectory.has_covariance = frame == Frame::map && has_all(first_sigma);

  std::size_t repeated = 0;
  std::string first_repeated;
  while (reader.next()) {
    auto point = frame == Frame::odom ? read_row<TrajectoryPoint>(reader, point_columns)
                                      : read_row<TrajectoryPoint>(reader, map_columns);
    for (std::size_t i = 0; i < 3; ++i)
      square(point.covariance[std::array<std::size_t, 3>{0, 3, 5}[i]], reader, first_sigma + i);
    if (!trajectory.points.empty()) {
      const TrajectoryPoint& before = trajectory.points.back();
      if (point.t_ns < before.t_ns) {
        reader.fail(0, "the time runs backwards; sort the rows by t");
      }
      if (point.t_ns == before.t_ns) {
        if (repeated++ == 0) first_repeated = reader.place();
        continue;
      }
      point.pose.yaw = unwrapped(point.pose.yaw, before.pose.yaw);
    }
    trajectory.points.push_back(point);
    for (std::size_t i = 0; i < further.size(); ++i)
      if (reader.has(first_further + i))
        trajectory.columns[i].push_back(reader.number(first_further + i));
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
  // A double represents differences of times to the nanosecond, but not always the times.
  const double share = static_cast<double>(t_ns - a.t_ns) / static_cast<double>(b.t_ns - a.t_ns);
  TrajectoryPoint point;
  point.t_ns = t_ns;
  point.pose = {mix(a.pose.x, b.pose.x, share), mix(a.pose.y, b.pose.y, share),
                mix(a.pose.yaw, b.pose.yaw, share)};
  point.motion = {mix(a.motion.v_x, b.motion.v_x, share), mix(a.motion.v_y, b.motion.v_y, share),
                  mix(a.motion.yaw_rate, b.motion.yaw_rate, share)};
  for (std::size_t i = 0; i < point.covariance.size(); ++i) {
    point.covariance[i] = mix(a.covariance[i], b.covariance[i], share);
  }
  point.reset_count = b.reset_count;
  return point;
}

std::optional<TrajectoryPoint> at(const Trajectory& trajectory, std::int64_t t_ns) {
  return at(trajectory, t_ns, trajectory.bridge_ns);
}

std::optional<TrajectoryPoint> at(const Trajectory& trajectory, std::int64_t t_ns,
                                  std::int64_t bridge_ns) {
  const auto& points = trajectory.points;
  const auto after =
      std::lower_bound(points.begin(), points.end(), t_ns,
                       [](const TrajectoryPoint& p, std::int64_t time) { return p.t_ns < time; });
  if (after == points.end()) return std::nullopt;
  if (after->t_ns == t_ns) return *after;
  if (after == points.begin()) return std::nullopt;
  if (after->t_ns - (after - 1)->t_ns > bridge_ns) return std::nullopt;
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
