// What the steering's response says of [steering]: delay, lag and rate limit of the actuator
// between a command and the front wheels, where there is one.
#pragma once

#include <string>
#include <vector>

#include "estimator/common/vehicle.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/identify/latency/steering_response.hpp"

namespace odomd::tools {

struct ActuatorFindings {
  std::vector<Finding> values;        ///< steering.delay, .lag, .rate_limit where there is one
  std::vector<std::string> warnings;  ///< of what the configuration has instead
};

/// `clock` is by how much the gyro's stamps, which the response is against, are late beyond their
/// configured latency [s]. Delay and lag are determined where the drive shows an actuator and
/// separates the two; the limit with them.
[[nodiscard]] ActuatorFindings actuator_findings(const SteeringResponse& response,
                                                 const Measured& clock,
                                                 const estimator::SteeringActuator& configured);

}  // namespace odomd::tools
