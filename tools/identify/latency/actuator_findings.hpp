// The values for [steering] from the steering's response: delay, lag and rate limit of the actuator
// between a command and the front wheels, if there is one.
#pragma once

#include <string>
#include <vector>

#include "daemon/diagnostics/diagnostic.hpp"
#include "estimator/common/vehicle.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/identify/latency/steering_response.hpp"

namespace odomd::tools {

struct ActuatorFindings {
  std::vector<Finding> values;        ///< steering.delay, .lag, .rate_limit where there is one
  diagnostics::Diagnostics warnings;  ///< about the configured values
};

/// `clock` is the excess of the latency of the gyro's stamps, the reference of the response, over
/// the configured one [s]. Delay and lag are determined if the drive shows an actuator and
/// separates the two, and with them the limit.
[[nodiscard]] ActuatorFindings actuator_findings(const SteeringResponse& response,
                                                 const Measured& clock,
                                                 const estimator::SteeringActuator& configured);

}  // namespace odomd::tools
