// Steady circles in a filmed drive, and the measurements on each.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/identify/common/measured.hpp"
#include "tools/identify/common/signal_log.hpp"
#include "tools/identify/stiffness/film.hpp"

namespace odomd::tools {

/// A stretch of steady turning: means over it, with standard uncertainties from their scatter. All
/// but steering, gyro and accelerometer come from the film. Left turns are positive.
struct CircleRun {
  std::string film;
  std::int64_t begin_ns = 0, end_ns = 0;  ///< film time
  double turned = 0.0;                    ///< [rad]
  double speed = 0.0;                     ///< of the centre of gravity [m/s]
  double yaw_rate = 0.0;                  ///< [rad/s]
  double lateral_accel = 0.0;             ///< v_x ψ̇ [m/s²]
  Measured drift;                         ///< direction of the velocity against the heading [rad]
  Measured steering;                      ///< from the log, at the front wheels [rad]
  Measured gyro;                          ///< yaw rate of the log [rad/s]
  Measured accelerometer;  ///< a_y of the log at the centre of gravity; sigma 0: none

  [[nodiscard]] double radius() const { return speed / std::abs(yaw_rate); }
};

struct Stretch {
  std::int64_t begin_ns = 0, end_ns = 0;
};

/// Stretches of at least half a turn with speed and yaw rate within 6 %, without their ends, where
/// the car settles.
[[nodiscard]] std::vector<Stretch> steady_stretches(const FilmMotion& motion);

/// `imu_y`: position of the accelerometer to the left of the centre of gravity [m]. A stretch with
/// too little steering data in the log is left out, with a warning.
[[nodiscard]] std::vector<CircleRun> measure_circles(const std::string& film,
                                                     const FilmMotion& motion, const SignalLog& log,
                                                     std::int64_t offset_ns, double imu_y,
                                                     diagnostics::Diagnostics& warnings);

}  // namespace odomd::tools
