#include "tools/identify/inertia/bifilar.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "tools/cli/text.hpp"
#include "tools/diagnostics/kinds.hpp"
#include "tools/identify/common/finding.hpp"

namespace odomd::tools {

using std::numbers::pi;

void check(const Bifilar& pendulum) {
  if (std::fabs(pendulum.spacing_above - pendulum.spacing_below) >= 2.0 * pendulum.cord)
    refuse(
        "--cord: cords of {} m do not reach from attachment points {} m apart to attachment points "
        "{} m apart",
        pendulum.cord, pendulum.spacing_above, pendulum.spacing_below);
}

std::string exchange_hint(const Bifilar& pendulum) {
  if (pendulum.cord >= pendulum.spacing_above) return {};
  return fmt::format(
      "; the cords of {:g} m are shorter than the {:g} m that they are apart: are --spacing and "
      "--cord exchanged?",
      pendulum.cord, pendulum.spacing_above);
}

// J / m = g p T² / (4 π² h(0))
double inertia_per_mass(const Bifilar& pendulum, double period, double gravity) {
  return gravity * pendulum.product() * period * period / (4.0 * pi * pi * pendulum.height());
}

// m / k³ with the radius of gyration k: about 3000 kg/m³ for a 1:10 car, 800 for a full-size car.
void check_size(const Bifilar& pendulum, double period, double mass) {
  const double radius = std::sqrt(inertia_per_mass(pendulum, period));
  const double spacing = pendulum.spacing_below, cube = radius * radius * radius;
  constexpr double lightest = 50.0, heaviest = 50e3;
  if (!(radius > 0.1 * spacing && radius < 10.0 * spacing))
    refuse(
        "a swing of {:.3g} s on cords {:.3g} m long and {:.3g} m apart means a radius of gyration "
        "of {:.2g} m: check --swings, --time, and the units of --spacing and --cord{}",
        period, pendulum.cord, spacing, radius, exchange_hint(pendulum));
  if (!(mass > lightest * cube && mass < heaviest * cube))
    refuse(
        "--mass: {:g} kg does not fit the radius of gyration of {:.2g} m from the swing; {:.2g} to "
        "{:.2g} kg would: check its unit, 2985g or 2.985, and those of --spacing and --cord{}",
        mass, radius, lightest * cube, heaviest * cube, exchange_hint(pendulum));
}

double lengthening(const Bifilar& pendulum, double radius_squared, double amplitude) {
  if (!(amplitude > 1e-6)) return 1.0;
  const double p = pendulum.product();
  const double top = pendulum.height(amplitude);
  if (!(top > 0.0) || amplitude > 0.5 * pi)
    refuse("--amplitude: {:.3g} rad is too large for these cords; 0.1 to 0.4 is good{}", amplitude,
           exchange_hint(pendulum));
  // ½ (k² + z'²) θ'² = g (z(A) - z(θ)); with θ = A sin φ the integrand of T = 4 ∫ dθ/θ' is
  // smooth, so that the midpoint rule is exact with few points. g cancels: it is 1 here.
  constexpr int points = 64;
  double sum = 0.0;
  for (int i = 0; i < points; ++i) {
    const double phi = 0.5 * pi * (i + 0.5) / points;
    const double angle = amplitude * std::sin(phi);
    const double cosine = std::cos(0.25 * pi + 0.5 * phi);
    const double missing = 2.0 * amplitude * cosine * cosine;  // A - θ
    const double height = pendulum.height(angle);
    const double rise =
        4.0 * p * std::sin(0.5 * (amplitude + angle)) * std::sin(0.5 * missing) / (height + top);
    const double slope = p * std::sin(angle) / height;
    sum += amplitude * std::cos(phi) * std::sqrt((radius_squared + slope * slope) / (2.0 * rise));
  }
  // T(0) = 2 π sqrt(k² h(0) / p)
  return sum / (points * std::sqrt(radius_squared * pendulum.height() / p));
}

TimedSwing small_period_of(const StopWatch& watch, const Bifilar& pendulum) {
  if (watch.times.empty() || watch.swings < 1) refuse("no timing of a swing is given");
  if (watch.amplitude_end > watch.amplitude_begin)
    refuse("--amplitude-end: a swing does not grow; it is {}",
           fmt::format("{:.3g} rad after {:.3g} rad", watch.amplitude_end, watch.amplitude_begin));
  const auto n = static_cast<double>(watch.times.size());
  const auto [mean, sigma_of_mean] = mean_of(watch.times);
  const double scatter = n > 1.0 ? sigma_of_mean * std::sqrt(n) : 0.0;
  const double period = mean / watch.swings;
  const double sigma = std::max(watch.sigma, scatter) / std::sqrt(n) / watch.swings;

  TimedSwing result;
  // The amplitude decays exponentially: mean of A² = (A0² - A1²) / (2 ln(A0/A1)).
  const double begin = watch.amplitude_begin, end = std::max(watch.amplitude_end, 1e-3 * begin);
  const double decay = begin > 0.0 ? std::log(begin / end) : 0.0;
  const double mean_square =
      decay > 1e-6 ? (begin * begin - end * end) / (2.0 * decay) : begin * begin;
  const double wide =
      lengthening(pendulum, inertia_per_mass(pendulum, period), std::sqrt(mean_square));
  // The timings together span the decay. T = T0 / sqrt(1 - ζ²).
  const double damping = decay / (2.0 * pi * watch.swings * n);
  const double slow = 1.0 / std::sqrt(1.0 - std::min(damping * damping, 0.5));
  result.lengthening = wide * slow - 1.0;
  result.period = {period / (1.0 + result.lengthening),
                   std::hypot(sigma, 0.25 * result.lengthening * period)};
  for (const double time : watch.times) {
    const double off = std::fabs(time - mean) / period;
    if (off > 0.4)
      refuse("--time: {} s and the mean of all, {:.2f} s, differ by {:.1f} swings; count again",
             time, mean, off);
  }
  if (n > 1.0 && scatter > 2.5 * watch.sigma)
    add_warning(result.warnings, tools::kind("timings_scatter"), {},
                "the timings scatter by {:.2f} s, more than --time-sigma {} s", scatter,
                watch.sigma);
  return result;
}

}  // namespace odomd::tools
