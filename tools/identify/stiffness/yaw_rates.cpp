#include "tools/identify/stiffness/yaw_rates.hpp"

#include <cmath>

namespace odomd::tools {
namespace {

constexpr std::int64_t half_window_ns = 200'000'000;

}  // namespace

YawRates yaw_rates_of(const FilmMotion& motion) {
  YawRates rates{motion.frames.front().t_ns, {}};
  for (std::int64_t t = rates.first_ns; t <= motion.frames.back().t_ns; t += YawRates::step_ns) {
    const auto local = local_motion(motion, t, half_window_ns);
    rates.value.push_back(local ? local->yaw_rate : std::numeric_limits<double>::quiet_NaN());
  }
  return rates;
}

// The slope of a straight line through ψ over ±h weighs the rates with a parabola, whose width is
// that of a mean over ±h √(3/5).
YawRates yaw_rates_of(const Series& gyro) {
  YawRates rates{gyro.t_ns.front(), {}};
  const auto half_ns =
      static_cast<std::int64_t>(std::sqrt(0.6) * static_cast<double>(half_window_ns));
  std::size_t begin = 0, end = 0;
  double sum = 0.0;
  for (std::int64_t t = rates.first_ns; t <= gyro.t_ns.back(); t += YawRates::step_ns) {
    for (; end < gyro.size() && gyro.t_ns[end] <= t + half_ns; ++end) sum += gyro.value[end];
    for (; begin < end && gyro.t_ns[begin] < t - half_ns; ++begin) sum -= gyro.value[begin];
    rates.value.push_back(end > begin ? sum / static_cast<double>(end - begin)
                                      : std::numeric_limits<double>::quiet_NaN());
  }
  return rates;
}

}  // namespace odomd::tools
