// Charts of pose files or of the running daemon, over time, and their trajectories.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/chart/picture.hpp"
#include "tools/drive_files/beat_histogram.hpp"
#include "tools/drive_files/trajectory.hpp"

namespace odomd::tools {

struct LiveTrack {
  Trajectory track;
  BeatHistogram beat;
};

/// Follows a running daemon for `seconds`, or until INT or TERM. The track has the columns of a
/// pose file. Throws like attach(), and std::runtime_error if no pose came.
[[nodiscard]] LiveTrack follow_daemon(const std::string& shm, double seconds, Frame frame,
                                      const std::vector<std::string>& further);

/// Values of calibrations by name, in SI units.
using Calibrations = std::map<std::string, double, std::less<>>;

/// The true calibrations of a simulated drive, from the plant.json in its folder, if there is a
/// single true value; none for other drives. Throws std::invalid_argument if the file is not of
/// odom sim.
[[nodiscard]] Calibrations true_calibrations(const std::filesystem::path& folder);

struct PlotInput {
  std::optional<Trajectory> reference;
  Calibrations truth;              ///< calibrations of the reference's drive
  std::vector<Trajectory> tracks;  ///< at least one; all with the columns of plot_columns()
  std::string title;
};

/// The quantities that can be drawn: "trajectory", "speed", ...
[[nodiscard]] std::vector<std::string> plot_quantities();

/// The columns to read from pose files in addition to the trajectory.
[[nodiscard]] std::vector<std::string> plot_columns();

/// Times are seconds since the first row of all tracks, or of each track if they do not overlap.
/// Throws std::invalid_argument, naming file and column, if no track has the quantity.
[[nodiscard]] std::vector<chart::Drawing> plot(std::string_view quantity, const PlotInput& input);

/// Whether all tracks, including the reference, have times in common.
[[nodiscard]] bool overlap(const PlotInput& input);

}  // namespace odomd::tools
