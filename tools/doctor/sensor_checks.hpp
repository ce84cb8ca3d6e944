// What doctor compares in a drive beyond the replay: scales and times.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "daemon/core/config.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/identify/common/signal_log.hpp"
#include "tools/identify/latency/latency_estimate.hpp"
#include "tools/replay/drive.hpp"

namespace odomd::tools::doctor {

/// The sensor whose scale is wrong: of all comparisons between sensors that a drive allows, those
/// that a factor on one of them, on an axle's wheels or on all wheels explains (scales.cpp).
/// Compares the wheels' distances, the turns by gyro, wheels and steering, and the accelerations,
/// with the camera's poses, else the reference's, else with each other. Nothing if no factor is
/// certain, or if the drive does not tell one sensor's from another's.
[[nodiscard]] std::optional<diagnostics::Diagnostic> find_wrong_scale(const Drive& drive,
                                                                      const SignalLog& log);

// Sensors whose latency is stated wrongly, and camera poses that are not on the bus's clock
// (latencies.cpp).

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
