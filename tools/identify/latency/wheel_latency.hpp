// How late wheel speeds are: a pair of them by the difference that a turn makes, one alone by its
// way over a camera's.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "estimator/common/measurement.hpp"
#include "tools/identify/latency/gyro_drive.hpp"

namespace odomd::tools {

/// How the front wheels point and the car drifts, on the gyro's clock.
struct FrontWheels {
  Resampled angle;       ///< δ [rad]
  Resampled side_speed;  ///< v_y of the centre of gravity [m/s]
};

/// Of both wheels of an axle; of the front ones better with `front_wheels`.
[[nodiscard]] SourceOffset wheel_pair(const GyroDrive& drive, estimator::Source left,
                                      estimator::Source right,
                                      const std::optional<FrontWheels>& front_wheels);

/// Of one wheel, axle or motor; `camera_offset` of the camera's stamps behind the gyro's [s].
[[nodiscard]] SourceOffset speed_by_camera(const GyroDrive& drive, estimator::Source source,
                                           std::span<const estimator::CameraPose> camera,
                                           double camera_offset);

/// The speed of the centre of gravity along x, of the wheels that are not driven where there are.
struct Speed {
  Resampled value;  ///< on the gyro's clock [m/s]
  estimator::Source source = estimator::Source::wheel_rear;
  bool driven = true;
  double offset_sigma = 0.0;  ///< [s]
};

/// Put into its place by what was found; empty where no wheel is mapped.
[[nodiscard]] std::optional<Speed> best_speed(const GyroDrive& drive,
                                              const std::vector<SourceOffset>& offsets);

}  // namespace odomd::tools
