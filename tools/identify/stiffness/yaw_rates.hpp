// The yaw rates of a film and of a gyro, smoothed alike and on one grid: so they can be compared.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "tools/identify/common/signal_log.hpp"
#include "tools/identify/stiffness/film_motion.hpp"

namespace odomd::tools {

/// On a grid of step_ns [rad/s]; NaN where not known.
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

}  // namespace odomd::tools
