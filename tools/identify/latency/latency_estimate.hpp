// How late each source's stamps are, seen from the others: every source tells something of how the
// car turns or speeds up, so each can be laid over the gyro (or what has been laid over it already)
// and moved in time until they agree.
#pragma once

#include <array>
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
  std::string against;     ///< in words: what it was laid over
  double offset = 0.0;     ///< of its stamps behind the gyro's [s]
  double sigma = 0.0;      ///< [s]
  double explained = 0.0;  ///< share of its variance that the other explains
  std::string doubt;       ///< why the offset means nothing; empty: it does
};

struct LatencyEstimate {
  std::vector<SourceOffset> offsets;  ///< of the sources that are mapped, without gyro and steering
  std::optional<SteeringResponse> steering;
  std::vector<std::string> warnings;
};

/// The offsets that can be told. Throws std::invalid_argument where there is no gyro in the log,
/// or less than ten seconds of drive, and what check_agreement() throws. `tell` hears how far it
/// is.
[[nodiscard]] LatencyEstimate estimate_latencies(const daemon::Config& config, const SignalLog& log,
                                                 std::span<const estimator::CameraPose> camera,
                                                 const TellProgress& tell = {});

}  // namespace odomd::tools
