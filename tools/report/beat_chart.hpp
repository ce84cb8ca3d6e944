// The histograms of a beat as charts.
#pragma once

#include <string>
#include <vector>

#include "tools/chart/drawing.hpp"
#include "tools/drive_files/beat_histogram.hpp"

namespace odomd::tools {

struct BeatChart {
  chart::Drawing drawing;
  std::string caption;  ///< median, 99 %, largest
};

/// Wake-up latency, and the work in a tick where it was measured. Both axes are logarithmic, so
/// that one late tick in a million is seen.
[[nodiscard]] std::vector<BeatChart> beat_charts(const BeatHistogram& beat);

}  // namespace odomd::tools
