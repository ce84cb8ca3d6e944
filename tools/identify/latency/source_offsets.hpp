// Time offsets of single sources: the drive's gyro on an even grid, and signals to compare with it,
// smoothed in the same way.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "daemon/core/config.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/identify/common/resampled.hpp"
#include "tools/identify/common/signal_log.hpp"
#include "tools/identify/common/time_shift.hpp"
#include "tools/identify/latency/latency_estimate.hpp"

namespace odomd::tools {

/// Times are seconds from the log's first frame.
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

/// Two cycles of a signal, within bounds: the interval for its derivative [s].
[[nodiscard]] inline double two_cycles(const Series& series) {
  return std::clamp(2.0 * series.cycle(), 0.01, 0.2);
}

[[nodiscard]] inline Resampled times(const Resampled& a, const Resampled& b) {
  return combined(a, b, std::multiplies{});
}

/// The constant function 1.
[[nodiscard]] inline Resampled constant(const Resampled& like) {
  return on_grid_of(like, [](double) { return 1.0; });
}

/// Averages twice over ± `half`. Use it on both compared signals: then neither is delayed against
/// the other, and the gyro's noise remains small after differentiation.
[[nodiscard]] inline Resampled smooth(const Resampled& signal, double half) {
  return mean_around(mean_around(signal, half), half);
}

[[nodiscard]] inline SourceOffset as_offset(estimator::Source source, std::string against,
                                            const Offset& found) {
  return {source, std::move(against), found.value, found.sigma, found.explained, found.failure};
}

/// The offset of both wheels of an axle, from their speed difference in curves; `front_wheels`
/// improves it for the front axle.
[[nodiscard]] SourceOffset wheel_pair(const GyroDrive& drive, estimator::Source left,
                                      estimator::Source right,
                                      const std::optional<FrontWheels>& front_wheels);

/// The offset of one wheel, axle or motor, from its distance compared with a camera's;
/// `camera_offset` is the delay of the camera's stamps behind the gyro's [s].
[[nodiscard]] SourceOffset speed_by_camera(const GyroDrive& drive, estimator::Source source,
                                           std::span<const estimator::CameraPose> camera,
                                           double camera_offset);

/// The speed of the centre of gravity along x [m/s], from undriven wheels if there are any, on the
/// gyro's clock according to the offset found; empty if no wheel is mapped.
[[nodiscard]] std::optional<Resampled> best_speed(const GyroDrive& drive,
                                                  const std::vector<SourceOffset>& offsets);

}  // namespace odomd::tools
