// Finds sensors whose latency is stated wrongly, and camera poses that are not on the bus's clock.
#pragma once

#include <span>
#include <string>

#include "daemon/core/config.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/identify/latency/latency_estimate.hpp"

namespace odomd::tools::doctor {

/// Of the steering's stamps behind what [steering] says of the wheels' response: at least, as its
/// actuator may be slower.
[[nodiscard]] SourceOffset offset_of(const SteeringResponse& response,
                                     const estimator::SteeringActuator& configured);

/// From the offsets against the gyro: each source that is off, or the gyro alone if all others are
/// off alike, and its latency explains that.
[[nodiscard]] diagnostics::Diagnostics examine_latencies(const daemon::Config& config,
                                                         std::span<const SourceOffset> offsets);

/// The sources of which the drive shows too little to judge their latency, in words; or empty.
[[nodiscard]] std::string latencies_unjudged(std::span<const SourceOffset> offsets);

}  // namespace odomd::tools::doctor
