// The response to steering: dead time and time constant between the steering signal and the front
// wheels, from the gyro; and the resulting values for [steering]: delay and lag of the actuator
// between a command and the front wheels, if there is one.
#pragma once

#include <string>

#include "estimator/common/vehicle.hpp"
#include "tools/cli/output.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/identify/common/measured.hpp"
#include "tools/identify/common/signal_log.hpp"

namespace odomd::tools {

/// Angle of the front wheels and side slip of the car over a drive, on the gyro's clock.
struct FrontWheels {
  Resampled angle;       ///< δ [rad]
  Resampled side_speed;  ///< v_y of the centre of gravity [m/s]
};

struct SteeringResponse {
  Measured dead_time;  ///< from the steering's stamps to the gyro's [s]; negative: a late sensor
  Measured time_constant;    ///< of the actuator [s]
  Measured in_all;           ///< their sum, more precise than either
  double explained = 0.0;    ///< share of the variance of the yaw rate
  FrontWheels front_wheels;  ///< from the fitted model
  std::string failure;       ///< why the values are not valid; empty if they are
};

/// Drives the single-track model over the whole log with steering and speed, and fits to the gyro:
/// dead time, time constant, the steering's scale and offset, the gyro's bias, and (within their
/// priors) stiffnesses, inertia and relaxation. `speed` and `gyro` share one clock. `report` is
/// called for every simulation.
[[nodiscard]] SteeringResponse steering_response(const estimator::Vehicle& car,
                                                 const Resampled& steering, const Resampled& speed,
                                                 const Series& gyro, std::int64_t origin_ns,
                                                 const ReportProgress& report = {});

/// Adds steering.delay and .lag, determined if the drive shows an actuator and separates the two,
/// and warns if it contradicts the configured values. `clock` is the latency of the gyro's stamps,
/// the reference of the response, in addition to the configured one [s].
void add_actuator(const SteeringResponse& response, const Measured& clock,
                  const estimator::SteeringActuator& configured, Findings& findings);

}  // namespace odomd::tools
