// Drives for other tools: MCAP for Foxglove, CSV for PlotJuggler, TUM for evo.
#pragma once

#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "daemon/diagnostics/diagnostic.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/drive_files/pose_csv.hpp"
#include "tools/drive_files/trajectory.hpp"
#include "tools/replay/log_options.hpp"

namespace odomd::tools {

// Everything that can be exported from a drive: poses, camera, truth and signals, from files or a
// replay.

struct ExportSource {
  std::filesystem::path drive;   ///< a pose file, or a folder of odom sim, record or import
  std::filesystem::path pose;    ///< instead of the folder's pose.csv; empty: that one
  std::filesystem::path config;  ///< instead of the folder's car.toml; empty: that one
  can::Damage damage = can::Damage::left_out;
};

/// Rows of a pose file, with non-decreasing times and the fields that the file contains.
struct PoseTable {
  std::vector<const PoseField*> fields;
  std::vector<std::int64_t> times_ns;
  std::vector<double> values;  ///< row by row

  [[nodiscard]] std::span<const double> row(std::size_t i) const {
    return std::span(values).subspan(i * fields.size(), fields.size());
  }
};

struct SignalSample {
  std::int64_t frame_ns = 0;  ///< stamp of the frame
  std::int64_t time_ns = 0;   ///< when it was measured
  estimator::Source source = estimator::Source::yaw_rate;
  double value = 0.0;  ///< SI
};

struct DriveData {
  PoseTable poses;
  std::vector<estimator::CameraPose> camera;  ///< in order of arrival
  std::optional<Trajectory> truth;
  std::vector<SignalSample> signals;  ///< in order of frames
  diagnostics::Diagnostics warnings;
};

/// Reads everything. A folder without poses is replayed. Throws std::invalid_argument for unusable
/// files.
[[nodiscard]] DriveData read_drive(const ExportSource& source);

// MCAP files (https://mcap.dev/spec, version 0): messages in compressed chunks, each with an index,
// followed by a summary, so that readers find any time and topic without reading everything.

struct McapStatistics {
  std::uint64_t messages = 0;
  std::uint64_t bytes = 0;  ///< of the file
  std::uint32_t topics = 0;
};

/// Messages are JSON, and come in the order of their times. For use by one thread.
class McapWriter {
 public:
  /// `out` belongs to this object until finish(). `library` names the program that writes.
  McapWriter(std::ostream& out, std::string_view library);

  /// `schema` is the name of the message's type; Foxglove recognises its own types by name
  /// (https://docs.foxglove.dev/docs/sdk/schemas) and members. The JSON schema follows from the
  /// first message; later messages with this schema must have the same members. Throws
  /// std::invalid_argument for a time before 0.
  void write(const std::string& topic, const std::string& schema, std::int64_t time_ns,
             const nlohmann::ordered_json& message);
  /// Ends the file. Check `out` for write errors.
  McapStatistics finish();

 private:
  using Id = std::uint16_t;
  struct Channel {
    Id id = 0;
    std::uint32_t messages = 0;
  };
  struct ChunkIndex {
    std::uint64_t start_ns = 0;
    std::uint64_t end_ns = 0;
    std::string rest;  ///< of the record: positions and sizes
  };

  void put(std::string_view bytes);
  Channel& channel_for(const std::string& topic, const std::string& schema,
                       const nlohmann::ordered_json& message);
  void end_chunk();
  void write_summary();

  std::ostream& out_;
  std::uint64_t written_ = 0;
  std::uint32_t crc_ = 0;  // of all bytes put since it was set to 0
  std::map<std::string, Id> schemas_;
  std::map<std::string, Channel> channels_;  // key: topic
  std::string schema_records_, channel_records_;
  std::string chunk_;                // records, not yet compressed
  std::map<Id, std::string> index_;  // of the current chunk: times and offsets of its messages
  std::uint64_t chunk_start_ns_ = 0;
  std::uint64_t chunk_end_ns_ = 0;
  std::vector<ChunkIndex> chunks_;
};

/// Writes the topics that docs/bridge.md lists, in order of time. Throws std::invalid_argument if
/// there is nothing to export, and for times before 0.
McapStatistics write_mcap(const DriveData& data, std::ostream& out);

/// Writes the poses: `time` in seconds, then the fields, named by their paths. Throws
/// std::invalid_argument if there is no pose.
void write_plot_csv(const PoseTable& poses, std::ostream& out);

/// The trajectories that the drive has, as texts per file name: pose.tum, odometry.tum, camera.tum
/// (at capture), truth.tum; lines of `timestamp x y z q_x q_y q_z q_w`. Throws
/// std::invalid_argument if there is none.
[[nodiscard]] std::map<std::string, std::string> tum_files(const DriveData& data);

}  // namespace odomd::tools
