#include "tools/identify/inertia/swing_timing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "daemon/diagnostics/diagnostic.hpp"

namespace odomd::tools {

TimedSwing small_period_of(const StopWatch& watch, const Bifilar& pendulum) {
  if (watch.times.empty() || watch.swings < 1)
    throw std::invalid_argument("no timing of a swing is given");
  if (watch.amplitude_end > watch.amplitude_begin)
    throw std::invalid_argument(
        "--amplitude-end: a swing does not grow; it is " +
        fmt::format("{:.3g} rad after {:.3g} rad", watch.amplitude_end, watch.amplitude_begin));
  const auto n = static_cast<double>(watch.times.size());
  double mean = 0.0;
  for (const double time : watch.times) mean += time / n;
  double squares = 0.0;
  for (const double time : watch.times) squares += (time - mean) * (time - mean);
  const double scatter = n > 1.0 ? std::sqrt(squares / (n - 1.0)) : 0.0;
  const double period = mean / watch.swings;
  const double sigma = std::max(watch.sigma, scatter) / std::sqrt(n) / watch.swings;

  TimedSwing result;
  // The amplitude decays exponentially: mean of A² = (A0² - A1²) / (2 ln(A0/A1)).
  const double begin = watch.amplitude_begin, end = std::max(watch.amplitude_end, 1e-3 * begin);
  const double decay = begin > 0.0 ? std::log(begin / end) : 0.0;
  const double mean_square =
      decay > 1e-6 ? (begin * begin - end * end) / (2.0 * decay) : begin * begin;
  const double radius_squared = inertia_of(pendulum, 1.0, 9.81, period);
  const double wide = lengthening(pendulum, radius_squared, std::sqrt(mean_square));
  // All timings together span the decay. T = T0 / sqrt(1 - ζ²).
  const double damping = decay / (2.0 * std::numbers::pi * watch.swings * n);
  const double slow = 1.0 / std::sqrt(1.0 - std::min(damping * damping, 0.5));
  result.lengthening = wide * slow - 1.0;
  result.period = {period / (1.0 + result.lengthening),
                   std::hypot(sigma, 0.25 * result.lengthening * period)};
  for (const double time : watch.times) {
    const double off = std::fabs(time - mean) / period;
    if (off > 0.4)
      throw std::invalid_argument(fmt::format(
          "--time: {} s and the mean of all, {:.2f} s, differ by {:.1f} swings; count again", time,
          mean, off));
  }
  if (n > 1.0 && scatter > 2.5 * watch.sigma)
    result.warnings.push_back(
        found(diagnostics::kind("timings_scatter"), {},
              fmt::format("the timings scatter by {:.2f} s, more than --time-sigma {} s", scatter,
                          watch.sigma)));
  return result;
}

}  // namespace odomd::tools
