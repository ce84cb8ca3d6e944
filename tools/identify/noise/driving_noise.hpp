// The noise of a sensor while the car drives, from the signal alone: from third differences, which
// remove the car's smooth motion.
#pragma once

#include <string>

#include "tools/identify/common/finding.hpp"
#include "tools/identify/common/signal_log.hpp"

namespace odomd::tools {

struct DrivingNoise {
  Measured sigma;       ///< of a sample, all of it
  Measured white;       ///< the part that is independent for each sample
  Measured increments;  ///< the part that the next sample cancels: counts of an encoder
  double samples = 0.0;
  bool smooth = false;  ///< the motion is removed; else sigma is too large
};

/// Of stretches with samples that follow each other evenly; samples that are 0 to the last bit (a
/// wheel that stands) are left out. `samples` is 0 if there are not enough of them.
[[nodiscard]] DrivingNoise driving_noise(const Series& series);

}  // namespace odomd::tools
