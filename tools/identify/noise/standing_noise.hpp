// The model of a sensor at standstill: y = b + v, v white with σ in each sample, b a random walk of
// K in the square root of a second. By maximum likelihood over all samples.
//
// If samples are correlated (a filter in the sensor, held values), v is not white: then means over
// as many samples as needed are used.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "tools/chart/drawing.hpp"
#include "tools/identify/common/measured.hpp"
#include "tools/identify/common/signal_log.hpp"

namespace odomd::tools {

/// A jump of a sensor from one level to another, which a bias does not do.
struct Jump {
  double after = 0.0;  ///< from the first sample [s]
  double size = 0.0;
};

struct StandingNoise {
  /// White noise of a sample. For correlated samples the value that gives the uncertainty of means
  /// of many of them.
  Measured sigma;
  Measured density;                ///< the same per √Hz: σ √(time between samples)
  Measured bias;                   ///< at the begin of the record
  std::optional<Measured> walk;    ///< K [unit/√s], if the record determines it
  double walk_below = 0.0;         ///< K is smaller than this with 97.5 %
  double sample_period = 0.0;      ///< mean [s]
  int outliers = 0;                ///< samples farther than 6 σ from what was expected
  bool outliers_left_out = false;  ///< they are few, and nothing of them is in the rest
  std::size_t together = 1;        ///< number of correlated samples that count as one
  double from_the_last = 0.0;      ///< error of the prediction from the samples before
  std::optional<Jump> jump;        ///< then the record determines no walk
  double resolution = 0.0;         ///< the steps in which the samples come
  /// The noise is smaller than the steps: `sigma` is that of their rounding, q/√12.
  bool resolution_hides_noise = false;
};

/// The bias's uncertainty includes the resolution of the samples. Throws std::invalid_argument,
/// naming `name`, for fewer than 200 samples or fewer than one in 2 s, and for a constant signal.
[[nodiscard]] StandingNoise standing_noise(const Series& series, const std::string& name);

// The Allan deviation: how much means over τ differ from one to the next (IEEE Std 952, annex C).

struct AllanPoint {
  double tau = 0.0;        ///< [s]
  double deviation = 0.0;  ///< in the signal's unit
  double sigma = 0.0;
};

/// Overlapping, at about six τ in each power of ten, up to a fifth of the record. Samples are taken
/// to be evenly spaced; `name` is for std::invalid_argument where they are not by far.
[[nodiscard]] std::vector<AllanPoint> allan_deviation(const Series& series,
                                                      const std::string& name);

struct BiasInstability {
  Measured value;        ///< the lowest of the curve over 0.664
  double tau = 0.0;      ///< where it is [s]
  bool reached = false;  ///< the curve rises again behind it: else it is an upper limit
};
[[nodiscard]] BiasInstability bias_instability(const std::vector<AllanPoint>& curve);

struct AllanCurve {
  std::string name;  ///< "yaw_rate"
  std::string unit;
  std::vector<AllanPoint> points;
  StandingNoise noise;
};

/// A picture of each curve, with what white noise and walk would make.
[[nodiscard]] std::vector<chart::Drawing> draw(const std::vector<AllanCurve>& curves);

}  // namespace odomd::tools
