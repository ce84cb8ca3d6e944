// The period of small swings from a gyro's record of a swing: the pendulum's equation of motion,
// its damping and its amplitude fitted to the yaw rate.
#pragma once

#include <string>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/identify/common/signal_log.hpp"
#include "tools/identify/inertia/bifilar.hpp"

namespace odomd::tools {

struct SwingFit {
  double period = 0.0;  ///< of small swings, undamped [s]
  double period_sigma = 0.0;
  double amplitude_begin = 0.0;  ///< of what was fitted [rad]
  double amplitude_end = 0.0;
  double damping_ratio = 0.0;  ///< viscous part, at small swings
  double gyro_bias = 0.0;      ///< [rad/s]
  double residual_rms = 0.0;   ///< [rad/s]
  double swings = 0.0;
  double seconds = 0.0;
  diagnostics::Diagnostics warnings;
};

/// Uses the record from its largest rate until the swing has decayed to a seventh. `name` is the
/// record's name in messages. Throws std::invalid_argument if it is not a swing, or too short.
[[nodiscard]] SwingFit fit_swing(const Series& yaw_rate, const Bifilar& pendulum,
                                 const std::string& name);

}  // namespace odomd::tools
