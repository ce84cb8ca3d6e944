// Estimates the latency of each source's stamps from the others: every source shows something of
// how the car turns or accelerates, so each can be compared with the gyro (or a source aligned with
// it already) and shifted in time until they agree.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "daemon/core/config.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/cli/progress.hpp"
#include "tools/identify/common/signal_log.hpp"
#include "tools/identify/latency/steering_response.hpp"

namespace odomd::tools {

/// A source's stamps against the gyro's.
struct SourceOffset {
  estimator::Source source = estimator::Source::yaw_rate;
  std::string against;     ///< in words: what it was compared with
  double offset = 0.0;     ///< of its stamps behind the gyro's [s]
  double sigma = 0.0;      ///< [s]
  double explained = 0.0;  ///< share of its variance that the other explains
  std::string failure;     ///< why the offset is not valid; empty: it is
};

struct LatencyEstimate {
  std::vector<SourceOffset> offsets;  ///< of the sources that are mapped, without gyro and steering
  std::optional<SteeringResponse> steering;
};

/// The offsets that can be determined. Throws std::invalid_argument if there is no gyro in the log,
/// or less than ten seconds of drive, and what check_agreement() throws. `report` gets the
/// progress.
[[nodiscard]] LatencyEstimate estimate_latencies(const daemon::Config& config, const SignalLog& log,
                                                 std::span<const estimator::CameraPose> camera,
                                                 const ReportProgress& report = {});

}  // namespace odomd::tools
