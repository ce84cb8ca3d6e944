// The offsets of single sources: a drive with its gyro on an even grid, and what is compared with
// the gyro, smoothed alike.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "daemon/core/config.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/identify/common/resampled.hpp"
#include "tools/identify/common/signal_log.hpp"
#include "tools/identify/latency/latency_estimate.hpp"

namespace odomd::tools {

// The time offset between two signals, where one is a sum of known functions of the other.
//
//   y(t_i) = Σ_j c_j φ_j(t_i - D) + e_i
//
// is solved for the coefficients c and the offset D: first over a grid of offsets (a
// cross-correlation with coefficients), then in continuous time (tools/math/least_squares.hpp), its
// covariance by blocks of time.
//
// Noise in φ_1 makes its derivative look larger than the signal's, and D better known than it is:
// of the energy of that derivative, less what the other functions explain, only the part that is
// not noise determines D.

struct BasisFunction {
  Resampled function;
  double expected = 0.0;                                   ///< of its coefficient
  double sigma = std::numeric_limits<double>::infinity();  ///< standard deviation of that
};

struct OffsetRegression {
  std::vector<double> t;  ///< [s], rising
  std::vector<double> y;
  std::vector<BasisFunction> basis;  ///< of these, the first is the one that carries the offset
  double range = 1.5;                ///< offsets from minus to plus this are tried [s]
  double block = 2.0;                ///< residuals further apart are independent [s]
  double slope_noise = 0.0;          ///< variance of the noise in the first function's derivative
};

struct Offset {
  double value = 0.0;  ///< D [s]: positive where y is late
  double sigma = std::numeric_limits<double>::infinity();
  std::vector<double> coefficients;
  double explained = 0.0;  ///< share of the variance of y, 0 to 1
  std::string failure;     ///< why the value is not valid; empty: it is
};

/// Needs at least 20 samples, else says so in `failure`.
[[nodiscard]] Offset solve(const OffsetRegression& regression);

/// Numbers the blocks of this length [s] that times lie in, for covariance_by_blocks().
[[nodiscard]] std::vector<std::size_t> blocks_of(const std::vector<double>& t, double length);

/// Seconds count from the log's first frame.
struct GyroDrive {
  const daemon::Config& config;
  const SignalLog& log;
  double begin = 0.0;
  double end = 0.0;
  Resampled yaw_rate;
  Resampled turned;  ///< its integral

  [[nodiscard]] Resampled on_grid(const Series& series) const {
    return resampled(series, log.first_ns, begin, end);
  }
};

/// Two cycles of a signal, within bounds: the span of derivatives [s].
[[nodiscard]] inline double two_cycles(const Series& series) {
  const double span = 1e-9 * static_cast<double>(series.t_ns.back() - series.t_ns.front());
  return std::clamp(2.0 * span / static_cast<double>(std::max<std::size_t>(series.size(), 2) - 1),
                    0.01, 0.2);
}

[[nodiscard]] inline Resampled times(const Resampled& a, const Resampled& b) {
  return combined(a, b, std::multiplies{});
}

/// 1
[[nodiscard]] inline Resampled constant(const Resampled& like) {
  return on_grid_of(like, [](double) { return 1.0; });
}

/// Applies the mean over ± half twice, to both signals compared, so that neither is delayed and the
/// gyro's noise remains small after differentiation.
[[nodiscard]] inline Resampled smooth(const Resampled& signal, double half) {
  return mean_around(mean_around(signal, half), half);
}

[[nodiscard]] inline SourceOffset as_offset(estimator::Source source, std::string against,
                                            const Offset& found) {
  return {source, std::move(against), found.value, found.sigma, found.explained, found.failure};
}

/// Of both wheels of an axle, from their difference in turns; `front_wheels` improves that of the
/// front ones.
[[nodiscard]] SourceOffset wheel_pair(const GyroDrive& drive, estimator::Source left,
                                      estimator::Source right,
                                      const std::optional<FrontWheels>& front_wheels);

/// Of one wheel, axle or motor, from its distance compared with a camera's; `camera_offset` of the
/// camera's stamps behind the gyro's [s].
[[nodiscard]] SourceOffset speed_by_camera(const GyroDrive& drive, estimator::Source source,
                                           std::span<const estimator::CameraPose> camera,
                                           double camera_offset);

/// The speed of the centre of gravity along x, from the wheels that are not driven if there are
/// any, on the gyro's clock by the offset found [m/s]; empty if no wheel is mapped.
[[nodiscard]] std::optional<Resampled> best_speed(const GyroDrive& drive,
                                                  const std::vector<SourceOffset>& offsets);

}  // namespace odomd::tools
