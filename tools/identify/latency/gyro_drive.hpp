// A drive for latency estimation: the gyro on an even grid, and the processing of signals that are
// compared with it.
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

/// Two cycles of a signal, within bounds: the span of derivatives [s].
[[nodiscard]] double two_cycles(const Series& series);

/// The noise of a sample, from third differences, which remove smooth motion; from the median of
/// their size, so that jerks and outliers do not count.
[[nodiscard]] double white_variance(const Series& series);

[[nodiscard]] Resampled shifted(Resampled signal, double later);
[[nodiscard]] Resampled times(const Resampled& a, const Resampled& b);
[[nodiscard]] Resampled constant(const Resampled& like);

/// Applies the mean over ± half twice, to both signals compared, so that neither is delayed and the
/// gyro's noise remains small after differentiation.
[[nodiscard]] Resampled smooth(const Resampled& signal, double half);

[[nodiscard]] SourceOffset as_offset(estimator::Source source, std::string against,
                                     const Offset& found);

}  // namespace odomd::tools
