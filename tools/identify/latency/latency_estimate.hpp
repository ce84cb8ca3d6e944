// Estimates the latency of each source's stamps from the other sources: every source shows
// something of the car's turning or acceleration, so each is compared with the gyro (or a source
// already aligned with it) and shifted in time until they agree.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "daemon/core/config.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/cli/output.hpp"
#include "tools/identify/common/signal_log.hpp"
#include "tools/identify/latency/steering_response.hpp"

namespace odomd::tools {

/// The offset of a source's stamps from the gyro's.
struct SourceOffset {
  estimator::Source source = estimator::Source::yaw_rate;
  std::string against;     ///< name of the source that it was compared with
  double offset = 0.0;     ///< delay of its stamps behind the gyro's [s]
  double sigma = 0.0;      ///< [s]
  double explained = 0.0;  ///< share of its variance that the comparison explains
  std::string failure;     ///< why the offset is not valid; empty if it is
};

struct LatencyEstimate {
  std::vector<SourceOffset> offsets;  ///< of all mapped sources except gyro and steering
  std::optional<SteeringResponse> steering;
};

/// The offsets that can be determined. Throws std::invalid_argument if the log has no gyro or less
/// than ten seconds of driving, and like check_agreement(). `report` receives the progress.
[[nodiscard]] LatencyEstimate estimate_latencies(const daemon::Config& config, const SignalLog& log,
                                                 std::span<const estimator::CameraPose> camera,
                                                 const ReportProgress& report = {});

}  // namespace odomd::tools
