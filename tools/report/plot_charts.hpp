// The charts of odom plot: one quantity of one or several tracks over time, or where they went.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/chart/drawing.hpp"
#include "tools/report/track.hpp"

namespace odomd::tools {

struct PlotInput {
  std::optional<Track> reference;
  std::vector<Track> tracks;  ///< at least one; all with the columns of plot_columns()
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
