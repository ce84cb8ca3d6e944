#include "tools/export/export.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <ostream>
#include <stdexcept>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "tools/bridge/odometry.hpp"
#include "tools/cli/csv.hpp"
#include "tools/drive_files/pose_csv.hpp"

namespace odomd::tools {
namespace {

using estimator::Pose2;
using Json = nlohmann::ordered_json;

using Columns = std::optional<std::array<std::size_t, 3>>;

/// The columns of x, y and yaw in the group of fields, if all are there.
Columns pose_columns(const PoseTable& poses, std::string_view group) {
  std::array<std::size_t, 3> columns{};
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const std::string path = fmt::format("{}/{}", group, std::array{"x", "y", "yaw"}[i]);
    const auto found = std::ranges::find(poses.fields, path, &PoseField::path);
    if (found == poses.fields.end()) return std::nullopt;
    columns[i] = static_cast<std::size_t>(found - poses.fields.begin());
  }
  return columns;
}

Pose2 pose_in(std::span<const double> row, const Columns& columns) {
  return {row[(*columns)[0]], row[(*columns)[1]], row[(*columns)[2]]};
}

Json time_json(std::int64_t time_ns) {
  constexpr std::int64_t second = 1'000'000'000;
  if (time_ns < 0) throw std::invalid_argument("a time lies before 0, which MCAP cannot store");
  return {{"sec", time_ns / second}, {"nsec", time_ns % second}};
}

Json position_json(const Pose2& pose) {
  return {{"x", pose.x}, {"y", pose.y}, {"z", 0.0}};
}

Json rotation_json(double yaw) {
  const PlanarQuaternion q = quaternion_of(yaw);
  return {{"x", 0.0}, {"y", 0.0}, {"z", q.z}, {"w", q.w}};
}

Json pose_in_map(const Json& time, const Pose2& pose) {
  return {{"timestamp", time},
          {"frame_id", "map"},
          {"pose", {{"position", position_json(pose)}, {"orientation", rotation_json(pose.yaw)}}}};
}

Json transform(const Json& time, const char* parent, const char* child, const Pose2& pose) {
  return {{"timestamp", time},
          {"parent_frame_id", parent},
          {"child_frame_id", child},
          {"translation", position_json(pose)},
          {"rotation", rotation_json(pose.yaw)}};
}

/// Items of one kind in the order of their times in the file.
struct Stream {
  std::size_t size = 0;
  std::function<std::int64_t(std::size_t)> time_ns;
  std::function<void(std::size_t, std::int64_t)> write;  ///< at this time in the file
  std::size_t next = 0;
};

class Topics {
 public:
  Topics(const DriveData& data, McapWriter& writer) : data_(data), writer_(writer) {}

  /// Writes all in order of time.
  void write() {
    while (true) {
      Stream* first = nullptr;
      std::int64_t first_ns = std::numeric_limits<std::int64_t>::max();
      for (Stream& stream : streams_)
        if (stream.next < stream.size && stream.time_ns(stream.next) < first_ns) {
          first = &stream;
          first_ns = stream.time_ns(stream.next);
        }
      if (first == nullptr) return;
      first->write(first->next++, first_ns);
    }
  }

 private:
  void write_pose(std::int64_t t_ns, std::span<const double> row) {
    const Json time = time_json(t_ns);
    const Pose2 map = pose_in(row, in_map_);
    writer_.write("/pose", "foxglove.PoseInFrame", t_ns, pose_in_map(time, map));
    Json transforms = Json::array();
    if (in_odom_) {
      const Pose2 odom = pose_in(row, in_odom_);
      transforms.push_back(transform(time, "map", "odom", correction_between(map, odom)));
      transforms.push_back(transform(time, "odom", "base_link", odom));
    } else {
      transforms.push_back(transform(time, "map", "base_link", map));
    }
    writer_.write("/tf", "foxglove.FrameTransforms", t_ns, {{"transforms", transforms}});
    Json record{{"timestamp", time}};
    for (std::size_t i = 0; i < row.size(); ++i) set_field(record, *data_.poses.fields[i], row[i]);
    writer_.write("/odomd/pose", "odomd.Pose", t_ns, record);
  }

  // The message is logged at the time of arrival; its timestamp is the time of capture.
  void write_camera(std::int64_t t_ns, const estimator::CameraPose& pose) {
    const Json time = time_json(pose.capture_ns);
    writer_.write("/camera/pose", "foxglove.PoseInFrame", t_ns,
                  pose_in_map(time, {pose.x, pose.y, pose.yaw}));
    writer_.write("/camera/measurement", "odomd.CameraPose", t_ns,
                  {{"timestamp", time},
                   {"x", pose.x},
                   {"y", pose.y},
                   {"yaw", pose.yaw},
                   {"sigma_x", pose.sigma_x},
                   {"sigma_y", pose.sigma_y},
                   {"sigma_yaw", pose.sigma_yaw},
                   {"latency", static_cast<double>(pose.arrival_ns - pose.capture_ns) * 1e-9}});
  }

  void write_truth(std::int64_t t_ns, const TrajectoryPoint& point) {
    const Pose2& pose = point.pose;
    const estimator::BodyVelocity& motion = point.motion;
    const Json time = time_json(t_ns);
    writer_.write("/truth/pose", "foxglove.PoseInFrame", t_ns, pose_in_map(time, pose));
    Json state{{"timestamp", time}, {"x", pose.x}, {"y", pose.y}, {"yaw", pose.yaw}};
    if (data_.truth->has_motion)
      state.update({{"vx", motion.v_x}, {"vy", motion.v_y}, {"yaw_rate", motion.yaw_rate}});
    writer_.write("/truth/state", "odomd.Truth", t_ns, state);
  }

  void write_signal(std::int64_t t_ns, const SignalSample& sample) {
    writer_.write(
        fmt::format("/can/{}", estimator::source_names[estimator::index_of(sample.source)]),
        "odomd.Signal", t_ns, {{"timestamp", time_json(sample.time_ns)}, {"value", sample.value}});
  }

  const DriveData& data_;
  McapWriter& writer_;
  Columns in_map_ = pose_columns(data_.poses, "map");
  Columns in_odom_ = pose_columns(data_.poses, "odom");
  std::array<Stream, 4> streams_{
      {{data_.truth ? data_.truth->points.size() : 0,
        [this](std::size_t i) { return data_.truth->points[i].t_ns; },
        [this](std::size_t i, std::int64_t t_ns) { write_truth(t_ns, data_.truth->points[i]); }},
       {data_.signals.size(), [this](std::size_t i) { return data_.signals[i].frame_ns; },
        [this](std::size_t i, std::int64_t t_ns) { write_signal(t_ns, data_.signals[i]); }},
       {data_.camera.size(), [this](std::size_t i) { return data_.camera[i].arrival_ns; },
        [this](std::size_t i, std::int64_t t_ns) { write_camera(t_ns, data_.camera[i]); }},
       {data_.poses.times_ns.size(), [this](std::size_t i) { return data_.poses.times_ns[i]; },
        [this](std::size_t i, std::int64_t t_ns) { write_pose(t_ns, data_.poses.row(i)); }}}};
};

}  // namespace

McapStatistics write_mcap(const DriveData& data, std::ostream& out) {
  if (data.poses.times_ns.empty() && data.signals.empty() && data.camera.empty() && !data.truth)
    throw std::invalid_argument("there is nothing to export");
  McapWriter writer(out, "odom " ODOMD_VERSION);
  Topics(data, writer).write();
  return writer.finish();
}

// PlotJuggler shows names with slashes as a tree.
void write_plot_csv(const PoseTable& poses, std::ostream& out) {
  if (poses.times_ns.empty())
    throw std::invalid_argument("there is no pose to export; give a pose file with --pose");
  std::string text = "time";
  for (const PoseField* field : poses.fields) text.append(",").append(field->path);
  text += '\n';
  for (std::size_t i = 0; i < poses.times_ns.size(); ++i) {
    append_seconds(text, poses.times_ns[i]);
    for (const double value : poses.row(i)) append_number(text += ',', value);
    out << text << '\n';
    text.clear();
  }
}

std::map<std::string, std::string> tum_files(const DriveData& data) {
  std::map<std::string, std::string> files;
  const auto add = [&](const char* file, std::int64_t t_ns, const Pose2& pose) {
    std::string& text =
        files.try_emplace(file, "# timestamp x y z q_x q_y q_z q_w\n").first->second;
    const PlanarQuaternion q = quaternion_of(pose.yaw);
    append_seconds(text, t_ns);
    text += fmt::format(" {} {} 0 0 0 {} {}\n", pose.x, pose.y, q.z, q.w);
  };
  const Columns in_map = pose_columns(data.poses, "map");
  const Columns in_odom = pose_columns(data.poses, "odom");
  for (std::size_t i = 0; i < data.poses.times_ns.size(); ++i) {
    add("pose.tum", data.poses.times_ns[i], pose_in(data.poses.row(i), in_map));
    if (in_odom) add("odometry.tum", data.poses.times_ns[i], pose_in(data.poses.row(i), in_odom));
  }
  std::vector<estimator::CameraPose> camera = data.camera;
  std::ranges::stable_sort(camera, {}, &estimator::CameraPose::capture_ns);
  for (const auto& pose : camera) add("camera.tum", pose.capture_ns, {pose.x, pose.y, pose.yaw});
  if (data.truth)
    for (const TrajectoryPoint& point : data.truth->points)
      add("truth.tum", point.t_ns, point.pose);
  if (files.empty()) throw std::invalid_argument("there is no trajectory to export");
  return files;
}

}  // namespace odomd::tools
