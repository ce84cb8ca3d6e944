#include "tools/export/formats.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <ostream>
#include <stdexcept>
#include <string>

#include <fmt/format.h>

#include "tools/bridge/odometry.hpp"
#include "tools/cli/csv.hpp"
#include "tools/drive_files/pose_csv.hpp"
#include "tools/export/schemas.hpp"

namespace odomd::tools {
namespace {

using estimator::Pose2;

constexpr std::string_view map_frame = "map";
constexpr std::string_view odom_frame = "odom";
constexpr std::string_view base_frame = "base_link";

constexpr std::array<std::string_view, 7> camera_numbers{
    "x", "y", "yaw", "sigma_x", "sigma_y", "sigma_yaw", "latency"};
constexpr std::array<std::string_view, 6> truth_numbers{"x", "y", "yaw", "vx", "vy", "yaw_rate"};
constexpr std::size_t truth_pose_numbers = 3;
constexpr std::array<std::string_view, 1> signal_numbers{"value"};

std::string time_json(std::int64_t time_ns) {
  constexpr std::int64_t second = 1'000'000'000;
  return fmt::format(R"({{"sec":{},"nsec":{}}})", time_ns / second, time_ns % second);
}

std::string position_json(const Pose2& pose) {
  return fmt::format(R"({{"x":{},"y":{},"z":0}})", pose.x, pose.y);
}

std::string rotation_json(double yaw) {
  const PlanarQuaternion q = quaternion_of(yaw);
  return fmt::format(R"({{"x":0,"y":0,"z":{},"w":{}}})", q.z, q.w);
}

std::string transform_json(const std::string& time, std::string_view parent, std::string_view child,
                           const Pose2& pose) {
  return fmt::format(
      R"({{"timestamp":{},"parent_frame_id":"{}","child_frame_id":"{}","translation":{},"rotation":{}}})",
      time, parent, child, position_json(pose), rotation_json(pose.yaw));
}

/// An item of the drive at its time in the file: number `index` of its kind.
struct Event {
  enum class Kind : std::uint8_t { truth, signal, camera, pose };
  std::int64_t time_ns = 0;
  Kind kind = Kind::pose;
  std::size_t index = 0;
};

std::vector<Event> events_of(const DriveData& data) {
  using Kind = Event::Kind;
  std::vector<Event> events;
  events.reserve(data.truth.size() + data.signals.size() + data.camera.size() +
                 data.poses.times_ns.size());
  for (std::size_t i = 0; i < data.truth.size(); ++i)
    events.push_back({data.truth[i].t_ns, Kind::truth, i});
  for (std::size_t i = 0; i < data.signals.size(); ++i)
    events.push_back({data.signals[i].frame_ns, Kind::signal, i});
  for (std::size_t i = 0; i < data.camera.size(); ++i)
    events.push_back({data.camera[i].arrival_ns, Kind::camera, i});
  for (std::size_t i = 0; i < data.poses.times_ns.size(); ++i)
    events.push_back({data.poses.times_ns[i], Kind::pose, i});
  std::ranges::stable_sort(events, {}, &Event::time_ns);
  return events;
}

/// The earliest time in the file: samples are older than the frames and messages that carried them.
std::int64_t earliest(const DriveData& data) {
  std::int64_t first = std::numeric_limits<std::int64_t>::max();
  for (const SignalSample& sample : data.signals) first = std::min(first, sample.time_ns);
  for (const auto& pose : data.camera) first = std::min(first, pose.capture_ns);
  if (!data.truth.empty()) first = std::min(first, data.truth.front().t_ns);
  if (!data.poses.times_ns.empty()) first = std::min(first, data.poses.times_ns.front());
  return first;
}

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

class Topics {
 public:
  Topics(const DriveData& data, std::int64_t zero_ns, McapWriter& writer)
      : data_(data), zero_ns_(zero_ns), writer_(writer) {
    const auto pose_in_frame = writer.add_schema("foxglove.PoseInFrame", pose_in_frame_schema());
    pose_ = writer.add_channel("/pose", pose_in_frame);
    tf_ = writer.add_channel(
        "/tf", writer.add_schema("foxglove.FrameTransforms", frame_transforms_schema()));
    record_ = writer.add_channel("/odomd/pose",
                                 writer.add_schema("odomd.Pose", pose_schema(data.poses.fields)));
    camera_pose_ = writer.add_channel("/camera/pose", pose_in_frame);
    camera_ = writer.add_channel(
        "/camera/measurement",
        writer.add_schema("odomd.CameraPose", numbers_schema("odomd.CameraPose", camera_numbers)));
    truth_pose_ = writer.add_channel("/truth/pose", pose_in_frame);
    truth_ = writer.add_channel(
        "/truth/state",
        writer.add_schema("odomd.Truth", numbers_schema("odomd.Truth", truth_columns())));
    const auto signal =
        writer.add_schema("odomd.Signal", numbers_schema("odomd.Signal", signal_numbers));
    for (std::size_t i = 0; i < signals_.size(); ++i)
      signals_[i] = writer.add_channel("/can/" + std::string(estimator::source_names[i]), signal);
    find_fields();
  }

  void write(const Event& event) {
    const std::int64_t t_ns = event.time_ns - zero_ns_;
    switch (event.kind) {
      case Event::Kind::pose:
        write_pose(t_ns, data_.poses.row(event.index));
        break;
      case Event::Kind::camera:
        write_camera(t_ns, data_.camera[event.index]);
        break;
      case Event::Kind::truth:
        write_truth(t_ns, data_.truth[event.index]);
        break;
      case Event::Kind::signal:
        write_signal(t_ns, data_.signals[event.index]);
        break;
    }
  }

 private:
  [[nodiscard]] std::span<const std::string_view> truth_columns() const {
    return std::span(truth_numbers)
        .first(data_.truth_has_motion ? truth_numbers.size() : truth_pose_numbers);
  }

  // Finds the pose's columns in a row; those in the odometry frame are optional.
  void find_fields() {
    in_map_ = pose_columns(data_.poses, "map");
    in_odom_ = pose_columns(data_.poses, "odom");
  }

  void write_pose_in_frame(McapWriter::Id channel, std::int64_t logged_ns, const std::string& time,
                           const Pose2& pose) {
    writer_.write(
        channel, logged_ns,
        fmt::format(
            R"({{"timestamp":{},"frame_id":"{}","pose":{{"position":{},"orientation":{}}}}})", time,
            map_frame, position_json(pose), rotation_json(pose.yaw)));
  }

  void write_pose(std::int64_t t_ns, std::span<const double> row) {
    const std::string time = time_json(t_ns);
    const Pose2 map = pose_in(row, in_map_);
    write_pose_in_frame(pose_, t_ns, time, map);
    std::string transforms;
    if (in_odom_) {
      const Pose2 odom = pose_in(row, in_odom_);
      transforms = transform_json(time, map_frame, odom_frame, correction_between(map, odom)) +
                   ',' + transform_json(time, odom_frame, base_frame, odom);
    } else {
      transforms = transform_json(time, map_frame, base_frame, map);
    }
    writer_.write(tf_, t_ns, fmt::format(R"({{"transforms":[{}]}})", transforms));

    std::string text;
    NestedJson json(text);
    json.raw("timestamp", time);
    const auto& fields = data_.poses.fields;
    std::optional<std::uint32_t> mode;
    for (std::size_t i = 0; i < fields.size(); ++i) {
      json.number(fields[i]->path, row[i]);
      if (fields[i]->path == mode_path) mode = static_cast<std::uint32_t>(row[i]);
    }
    if (mode) json.text("mode_name", mode_name(*mode));
    json.end();
    writer_.write(record_, t_ns, text);
  }

  void write_numbers(McapWriter::Id channel, std::int64_t logged_ns, const std::string& time,
                     std::span<const std::string_view> names, std::span<const double> values) {
    std::string text;
    NestedJson json(text);
    json.raw("timestamp", time);
    for (std::size_t i = 0; i < names.size(); ++i) json.number(names[i], values[i]);
    json.end();
    writer_.write(channel, logged_ns, text);
  }

  // The message is logged at the arrival; its timestamp is the capture.
  void write_camera(std::int64_t t_ns, const estimator::CameraPose& pose) {
    const std::string time = time_json(pose.capture_ns - zero_ns_);
    write_pose_in_frame(camera_pose_, t_ns, time, {pose.x, pose.y, pose.yaw});
    const std::array values{pose.x,
                            pose.y,
                            pose.yaw,
                            pose.sigma_x,
                            pose.sigma_y,
                            pose.sigma_yaw,
                            static_cast<double>(pose.arrival_ns - pose.capture_ns) * 1e-9};
    write_numbers(camera_, t_ns, time, camera_numbers, values);
  }

  void write_truth(std::int64_t t_ns, const TrajectoryPoint& point) {
    const std::string time = time_json(t_ns);
    write_pose_in_frame(truth_pose_, t_ns, time, point.pose);
    const std::array values{point.pose.x,    point.pose.y,    point.pose.yaw,
                            point.motion.vx, point.motion.vy, point.motion.yaw_rate};
    write_numbers(truth_, t_ns, time, truth_columns(), values);
  }

  void write_signal(std::int64_t t_ns, const SignalSample& sample) {
    write_numbers(signals_[static_cast<std::size_t>(sample.source)], t_ns,
                  time_json(sample.time_ns - zero_ns_), signal_numbers,
                  std::span(&sample.value, 1));
  }

  const DriveData& data_;
  std::int64_t zero_ns_;
  McapWriter& writer_;
  McapWriter::Id pose_ = 0;
  McapWriter::Id tf_ = 0;
  McapWriter::Id record_ = 0;
  McapWriter::Id camera_pose_ = 0;
  McapWriter::Id camera_ = 0;
  McapWriter::Id truth_pose_ = 0;
  McapWriter::Id truth_ = 0;
  std::array<McapWriter::Id, estimator::source_count> signals_{};
  Columns in_map_;
  Columns in_odom_;
};

}  // namespace

McapStatistics write_mcap(const DriveData& data, ExportTime time, McapCompression compression,
                          std::ostream& out) {
  const std::vector<Event> events = events_of(data);
  if (events.empty()) throw std::invalid_argument("there is nothing to export");
  const std::int64_t first_ns = earliest(data);
  if (time == ExportTime::absolute && first_ns < 0)
    throw std::invalid_argument(
        "a time lies before 0, which MCAP cannot store; add --relative-time");
  McapWriter writer(out, compression, "odom " ODOMD_VERSION);
  Topics topics(data, time == ExportTime::relative ? first_ns : 0, writer);
  for (const Event& event : events) topics.write(event);
  return writer.finish();
}

// PlotJuggler shows names with slashes as a tree.
void write_plot_csv(const PoseTable& poses, ExportTime time, std::ostream& out) {
  if (poses.times_ns.empty())
    throw std::invalid_argument("there is no pose to export; give a pose file with --pose");
  std::string text = "time";
  for (const PoseField* field : poses.fields) text.append(",").append(field->path);
  text += '\n';
  const std::int64_t zero_ns = time == ExportTime::relative ? poses.times_ns.front() : 0;
  for (std::size_t i = 0; i < poses.times_ns.size(); ++i) {
    append_seconds(text, poses.times_ns[i] - zero_ns);
    for (const double value : poses.row(i)) {
      text += ',';
      append_number(text, value);
    }
    text += '\n';
    constexpr std::size_t batch = 1U << 20U;
    if (text.size() < batch) continue;
    out << text;
    text.clear();
  }
  out << text;
}

std::map<std::string, std::string> tum_files(const DriveData& data, ExportTime time) {
  const std::int64_t zero_ns = time == ExportTime::relative ? earliest(data) : 0;
  std::map<std::string, std::string> files;
  const auto add = [&](const char* file, std::int64_t t_ns, const Pose2& pose) {
    std::string& text =
        files.try_emplace(file, "# timestamp x y z q_x q_y q_z q_w\n").first->second;
    const PlanarQuaternion q = quaternion_of(pose.yaw);
    append_seconds(text, t_ns - zero_ns);
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
  for (const TrajectoryPoint& point : data.truth) add("truth.tum", point.t_ns, point.pose);
  if (files.empty()) throw std::invalid_argument("there is no trajectory to export");
  return files;
}

}  // namespace odomd::tools
