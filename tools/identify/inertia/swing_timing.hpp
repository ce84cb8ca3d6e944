// The period of small swings from timings by stop-watch.
#pragma once

#include <string>
#include <vector>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/identify/inertia/bifilar.hpp"

namespace odomd::tools {

struct StopWatch {
  std::vector<double> times;  ///< each of `swings` swings [s]
  int swings = 0;
  double sigma = 0.0;            ///< of a timing [s]
  double amplitude_begin = 0.0;  ///< of the first swing that was timed [rad]
  double amplitude_end = 0.0;    ///< ... of the last
};

struct TimedSwing {
  Measured period;           ///< of small, undamped swings [s]
  double lengthening = 0.0;  ///< relative excess of the timed period
  diagnostics::Diagnostics warnings;
};

/// The mean of the timings, corrected for the swings' width and damping; a quarter of the
/// correction counts as uncertainty. Throws std::invalid_argument for impossible values.
[[nodiscard]] TimedSwing small_period_of(const StopWatch& watch, const Bifilar& pendulum);

}  // namespace odomd::tools
