// Writes a drive for other tools: MCAP for Foxglove, CSV for PlotJuggler, TUM for evo.
#pragma once

#include <iosfwd>
#include <map>
#include <string>

#include "tools/export/drive_data.hpp"
#include "tools/export/mcap_writer.hpp"

namespace odomd::tools {

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
