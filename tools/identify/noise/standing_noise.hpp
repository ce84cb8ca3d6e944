// The model of a sensor at rest: y = b + v, v white with σ in each sample, b a random walk with K
// per square root of a second. Fitted with maximum likelihood over all samples.
//
// If samples are correlated (a filter in the sensor, held values), v is not white: then means over
// as many samples as necessary are used.
#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <string>

#include "tools/identify/common/measured.hpp"
#include "tools/identify/common/signal_log.hpp"

namespace odomd::tools {

struct StandingNoise {
  /// White noise of a sample. For correlated samples the value that gives the right uncertainty for
  /// means of many samples.
  Measured sigma;
  Measured bias;                   ///< at the start of the record
  std::optional<Measured> walk;    ///< K [unit/√s], if the record determines it
  double walk_below = 0.0;         ///< upper limit of K (97.5 %)
  double sample_period = 0.0;      ///< mean [s]
  int outliers = 0;                ///< samples more than 6 σ from their prediction
  bool outliers_left_out = false;  ///< they are few, and affect nothing else here
  std::size_t group_size = 1;      ///< number of correlated samples that count as one
  double prediction_error = 0.0;   ///< error of a sample's prediction from earlier samples
  double resolution = 0.0;         ///< step between adjacent values
  /// The noise is smaller than the resolution: `sigma` is the rounding noise, q/√12.
  bool resolution_hides_noise = false;

  /// White noise per √Hz: σ √(time between samples)
  [[nodiscard]] Measured density() const {
    const double root = std::sqrt(sample_period);
    return {sigma.value * root, sigma.sigma * root};
  }
};

/// The bias's uncertainty includes the resolution. Throws std::invalid_argument, with `name`, for
/// fewer than 200 samples or fewer than one in 2 s, and for a constant signal.
[[nodiscard]] StandingNoise standing_noise(const Series& series, const std::string& name);

}  // namespace odomd::tools
