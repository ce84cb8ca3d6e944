// Charts of an evaluated drive: timing of ticks, innovations, and the map.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "estimator/common/measurement.hpp"
#include "tools/chart/chart.hpp"
#include "tools/chart/picture.hpp"
#include "tools/drive_files/beat_histogram.hpp"
#include "tools/evaluation/evaluated_drive.hpp"

namespace odomd::tools {

struct Figure {
  chart::Drawing drawing;
  std::string caption;  ///< describes the drawing in one or two sentences
};

/// Wake-up latency, and the execution time of a tick if it was measured. Both axes are logarithmic,
/// so that one late tick in a million is visible. Captions: median, 99 %, largest.
[[nodiscard]] std::vector<Figure> beat_charts(const BeatHistogram& beat);

/// A chart for every dimension of every tested source, in the order of the sources: ν as dots,
/// gated ones in another colour, and the band ±3√S. Times are seconds after `zero_ns`.
[[nodiscard]] std::vector<chart::Chart> innovation_charts(
    std::span<const estimator::Judgement> judgements, std::int64_t zero_ns);

/// A map without trajectories.
[[nodiscard]] chart::Chart empty_map(const std::string& title);

/// Reference and aligned estimates within their common time, camera poses as dots; cm/m and heading
/// error in the legend.
[[nodiscard]] chart::Chart evaluation_map(const EvaluatedDrive& drive, const std::string& title);

}  // namespace odomd::tools
