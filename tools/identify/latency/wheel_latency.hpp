// Latencies of wheel speeds: of a pair from their difference in turns, of one alone from its
// distance compared with a camera's.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "estimator/common/measurement.hpp"
#include "tools/identify/latency/gyro_drive.hpp"

namespace odomd::tools {

/// Angle of the front wheels and side slip of the car, on the gyro's clock.
struct FrontWheels {
  Resampled angle;       ///< δ [rad]
  Resampled side_speed;  ///< v_y of the centre of gravity [m/s]
};

/// Of both wheels of an axle; `front_wheels` improves that of the front ones.
[[nodiscard]] SourceOffset wheel_pair(const GyroDrive& drive, estimator::Source left,
                                      estimator::Source right,
                                      const std::optional<FrontWheels>& front_wheels);

/// Of one wheel, axle or motor; `camera_offset` of the camera's stamps behind the gyro's [s].
[[nodiscard]] SourceOffset speed_by_camera(const GyroDrive& drive, estimator::Source source,
                                           std::span<const estimator::CameraPose> camera,
                                           double camera_offset);

/// The speed of the centre of gravity along x, from the wheels that are not driven if there are
/// any.
struct Speed {
  Resampled value;  ///< on the gyro's clock [m/s]
  estimator::Source source = estimator::Source::wheel_rear;
  bool driven = true;
  double offset_sigma = 0.0;  ///< [s]
};

/// Shifted by the offset found; empty if no wheel is mapped.
[[nodiscard]] std::optional<Speed> best_speed(const GyroDrive& drive,
                                              const std::vector<SourceOffset>& offsets);

}  // namespace odomd::tools
