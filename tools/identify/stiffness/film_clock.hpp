// The film's clock against the log's: where the film begins and how fast its time runs, by least
// squares of the yaw rates of film and gyro.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "tools/identify/common/signal_log.hpp"
#include "tools/identify/stiffness/film_motion.hpp"

namespace odomd::tools {

/// The yaw rates of a film or a gyro, smoothed alike, on a grid of step_ns: so they can be compared
/// [rad/s]; NaN where not known.
struct YawRates {
  static constexpr std::int64_t step_ns = 20'000'000;

  std::int64_t first_ns = 0;
  std::vector<double> value;

  [[nodiscard]] std::int64_t size() const { return static_cast<std::int64_t>(value.size()); }
  [[nodiscard]] double at(std::int64_t k) const {
    return k < 0 || k >= size() ? std::numeric_limits<double>::quiet_NaN()
                                : value[static_cast<std::size_t>(k)];
  }

  [[nodiscard]] static double seconds(std::int64_t steps) {
    return 1e-9 * static_cast<double>(steps * step_ns);
  }
};

[[nodiscard]] YawRates yaw_rates_of(const FilmMotion& motion);
[[nodiscard]] YawRates yaw_rates_of(const Series& gyro);

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
