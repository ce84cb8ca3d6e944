// The noise of a sensor while the car drives, from the signal alone: what is left of it in the
// third differences, in which the car's smooth motion is gone.
#pragma once

#include <string>

#include "tools/identify/common/finding.hpp"
#include "tools/identify/common/signal_log.hpp"

namespace odomd::tools {

struct DrivingNoise {
  Measured sigma;       ///< of a sample, all of it
  Measured white;       ///< the part that is drawn anew for each sample
  Measured increments;  ///< the part that the next sample takes back: of counts of an encoder
  double samples = 0.0;
  bool smooth = false;  ///< the motion really is gone; else sigma is too large
};

/// Of stretches with samples that follow each other evenly; samples that are 0 to the last bit (a
/// wheel that stands) are left out. `samples` is 0 where there are not enough of them.
[[nodiscard]] DrivingNoise driving_noise(const Series& series);

}  // namespace odomd::tools
