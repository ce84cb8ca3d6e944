// The film's clock against the log's: where the film begins and how fast its time runs, by least
// squares of the yaw rates.
#pragma once

#include <cstdint>

#include "tools/identify/stiffness/yaw_rates.hpp"

namespace odomd::tools {

struct FilmClock {
  double begin = 0.0;        ///< of the film on the gyro's grid [steps]
  double begin_sigma = 0.0;  ///< standard uncertainty [steps]
  double rate = 0.0;         ///< log seconds a film's - 1
  double rate_sigma = 0.0;
  enum class Kind : std::uint8_t { usual, surprising };
  Kind kind = Kind::usual;  ///< surprising: the rate is none of a good clock
};

/// From a shift that is good to about a second. The gyro's scale and bias are left free. A rate
/// within 0.3 % is held to 0.1 %, as clocks and nominal frame rates are.
[[nodiscard]] FilmClock fit_clock(const YawRates& film, const YawRates& gyro, std::int64_t shift);

}  // namespace odomd::tools
