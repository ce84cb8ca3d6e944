// The speed that the accelerometer tells: what it was, and what has been felt since.
#pragma once

#include "estimator/integrity/parity.hpp"

namespace odomd::estimator::integrity {

/// What is slower teaches nothing [m/s].
inline constexpr double slowest_learning = 0.3;

/// Goes on by what was felt for `dt` [s].
void feel(const Sensors& sensors, Heard& heard, double dt) noexcept;

/// To be asked as long as all wheels are distrusted: the felt speed is none once the car rests.
void rest_with_locked_wheels(Heard& heard) noexcept;

/// How the others stand, by which the felt speed is told.
struct Others {
  bool felt = false;          ///< the accelerometer is heard, and believed
  bool told = false;          ///< wheels or a camera tell the speed
  bool contradicted = false;  ///< they do not agree
  bool sound = false;         ///< neither they nor the accelerometer are in doubt
};

/// Follows the speed that was agreed on, and learns what is felt more on a slope, or by a bias.
void follow(Heard& heard, double dt, const Others& others) noexcept;

}  // namespace odomd::estimator::integrity
