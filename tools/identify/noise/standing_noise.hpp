// What a sensor says while the car stands: y = b + v, v white with σ in each sample, b a random
// walk of K in the square root of a second. By maximum likelihood over all samples.
//
// Where samples hang together (a filter in the sensor, values that are held), v is not white: then
// it is done with the means over so many samples that these are.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "tools/identify/common/finding.hpp"
#include "tools/identify/common/signal_log.hpp"

namespace odomd::tools {

/// Where a sensor goes from one level to another, which no bias does.
struct Jump {
  double after = 0.0;  ///< from the first sample [s]
  double size = 0.0;
};

struct StandingNoise {
  /// White, of a sample. Of samples that hang together as large as makes the means of many of them
  /// as uncertain as they are.
  Measured sigma;
  Measured density;  ///< the same per √Hz: σ √(time between samples)
  Measured bias;     ///< at the begin of the record
  Measured bias_at_end;
  std::optional<Measured> walk;    ///< K [unit/√s], where the record tells it
  double walk_below = 0.0;         ///< K is smaller than this with 97.5 %
  double sample_period = 0.0;      ///< mean [s]
  int outliers = 0;                ///< samples farther than 6 σ from what was expected
  bool outliers_left_out = false;  ///< they are few, and nothing of them is in the rest
  std::size_t together = 1;        ///< samples that are no more white than one of them
  double from_the_last = 0.0;      ///< how far a sample lies off what the ones before it say
  std::optional<Jump> jump;        ///< then the record tells no walk
  double resolution = 0.0;         ///< the steps in which the samples come
  /// The noise is smaller than the steps: `sigma` is that of their rounding, q/√12.
  bool resolution_hides_noise = false;
};

/// In the bias's uncertainty is what the steps of the samples leave of it.
/// Throws std::invalid_argument, naming `name`, for fewer than 200 samples or one in more than 2 s,
/// and for a sensor that says the same all the time.
[[nodiscard]] StandingNoise standing_noise(const Series& series, const std::string& name);

}  // namespace odomd::tools
