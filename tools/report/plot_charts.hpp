// Charts of pose files or of the running daemon, over time, and their trajectories.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/chart/drawing.hpp"
#include "tools/drive_files/beat_histogram.hpp"
#include "tools/drive_files/trajectory.hpp"

namespace odomd::tools {

struct LiveTrack {
  Trajectory track;
  BeatHistogram beat;
};

/// Follows a running daemon for so long, or until INT: the columns are those of a pose file. Throws
/// as attach() does, and std::runtime_error where no pose came.
[[nodiscard]] LiveTrack follow_daemon(const std::string& shm, double seconds, Frame frame,
                                      const std::vector<std::string>& further);

/// By their names, in SI units.
using Calibrations = std::map<std::string, double, std::less<>>;

/// Of a simulated drive, by the plant.json in its folder, as far as there is one right value; of
/// other drives none. Throws std::invalid_argument for a file that is not one of odom sim.
[[nodiscard]] Calibrations true_calibrations(const std::filesystem::path& folder);

struct PlotInput {
  std::optional<Trajectory> reference;
  Calibrations truth;              ///< of the drive of the reference
  std::vector<Trajectory> tracks;  ///< at least one; all with the columns of plot_columns()
  std::string title;
};

/// What can be drawn: "trajectory", "speed", ...
[[nodiscard]] std::vector<std::string> plot_quantities();

/// The columns to read from pose files in addition to the trajectory.
[[nodiscard]] std::vector<std::string> plot_columns();

/// Times are seconds since the first row of all; of tracks that do not overlap, of each. Throws
/// std::invalid_argument, naming file and column, where no track has what is to be drawn.
[[nodiscard]] std::vector<chart::Drawing> plot(std::string_view quantity, const PlotInput& input);

/// Whether all tracks, the reference too, have times in common.
[[nodiscard]] bool overlap(const PlotInput& input);

}  // namespace odomd::tools
