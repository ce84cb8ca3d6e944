// Checks that a record is of a standing car.
#pragma once

#include <string>
#include <vector>

#include "tools/identify/common/signal_log.hpp"
#include "tools/identify/noise/allan.hpp"

namespace odomd::tools {

/// Whether no wheel turns faster than `limit` [m/s]; also true if the log has no wheel.
[[nodiscard]] bool wheels_stand(const SignalLog& log, double limit);

[[nodiscard]] bool has_wheels(const SignalLog& log);

/// Throws std::invalid_argument, with the time, if a wheel of the log turns.
void check_that_wheels_stand(const SignalLog& log, const std::string& record);

/// Checks what the IMU can show: throws std::invalid_argument for a yaw rate that leaves its median
/// by 3 degrees a second where the noise of a sample is much smaller, and, without wheels, for a
/// sensor whose Allan deviation turns below a second and then doubles, which no bias does. `curves`
/// are those of the log.
void check_that_imu_stands(const SignalLog& log, const std::vector<AllanCurve>& curves,
                           const std::string& record);

}  // namespace odomd::tools
