// What a sensor says while the car stands: y = b + v, v white with σ in each sample, b a random
// walk of K in the square root of a second. By maximum likelihood over all samples.
#pragma once

#include <optional>

#include "tools/identify/finding.hpp"
#include "tools/identify/signal_log.hpp"

namespace odomd::tools {

struct StandingNoise {
  Measured sigma;    ///< white, of a sample
  Measured density;  ///< the same per √Hz: σ √(time between samples)
  Measured bias;     ///< at the begin of the record
  Measured bias_at_end;
  std::optional<Measured> walk;  ///< K [unit/√s], where the record tells it
  double walk_below = 0.0;       ///< K is smaller than this with 97.5 %
  double sample_period = 0.0;    ///< mean [s]
  int outliers = 0;              ///< samples farther than 6 σ from what was expected
  double resolution = 0.0;       ///< the steps in which the samples come
  /// The noise is smaller than the steps: `sigma` is that of their rounding, q/√12.
  bool resolution_hides_noise = false;
};

/// In the bias's uncertainty is what the steps of the samples leave of it.
/// Throws std::invalid_argument, naming `name`, for fewer than 200 samples, and for a sensor that
/// says the same all the time.
[[nodiscard]] StandingNoise standing_noise(const Series& series, const std::string& name);

}  // namespace odomd::tools
