// A drive as its latencies are found in it: the gyro's turn on an even grid, and what is done to
// signals that are laid over it.
#pragma once

#include <cstdint>
#include <string>

#include "daemon/core/config.hpp"
#include "tools/identify/common/resampled.hpp"
#include "tools/identify/common/signal_log.hpp"
#include "tools/identify/latency/latency_estimate.hpp"
#include "tools/identify/latency/offset_regression.hpp"

namespace odomd::tools {

/// Seconds count from the log's first frame.
struct GyroDrive {
  const daemon::Config& config;
  const SignalLog& log;
  double begin = 0.0;
  double end = 0.0;
  Resampled yaw_rate;
  Resampled turned;  ///< its integral

  [[nodiscard]] double seconds(std::int64_t t_ns) const {
    return 1e-9 * static_cast<double>(t_ns - log.first_ns);
  }
  [[nodiscard]] Resampled on_grid(const Series& series) const {
    return resampled(series, log.first_ns, begin, end);
  }
};

/// Two cycles of a signal, within bounds: what derivatives are taken over [s].
[[nodiscard]] double two_cycles(const Series& series);

/// Of a sample, by third differences, in which smooth motion is gone; the median of their size, so
/// that jerks and outliers do not count.
[[nodiscard]] double white_variance(const Series& series);

[[nodiscard]] Resampled shifted(Resampled signal, double later);
[[nodiscard]] Resampled times(const Resampled& a, const Resampled& b);
[[nodiscard]] Resampled constant(const Resampled& like);

/// Twice the mean over ± half: of a signal and of what it is laid over alike, so that neither is
/// late, and that the gyro's noise, differentiated, stays below what is differentiated.
[[nodiscard]] Resampled smooth(const Resampled& signal, double half);

[[nodiscard]] SourceOffset as_offset(estimator::Source source, std::string against,
                                     const Offset& found);

}  // namespace odomd::tools
