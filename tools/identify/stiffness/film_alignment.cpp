#include "tools/diagnostics/kinds.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/identify/stiffness/film.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "tools/cli/text.hpp"
#include "tools/identify/common/time_shift.hpp"

namespace odomd::tools {
namespace {

constexpr std::int64_t coarse = 5;  // steps
constexpr double good_agreement = 0.9;
constexpr std::int64_t smoothing_ns = 200'000'000;  // half of the window of a yaw rate

// Covers two quartz clocks, and a film of 29.97 frames per second taken for 30.
constexpr double clock_sigma = 1e-3;
// A difference above an uncalibrated gyro's scale error comes from the film's clock.
constexpr double surprising_rate = 0.025;

// The yaw rates of a film or a gyro on an even grid [rad/s], smoothed in the same way, so that they
// can be compared; NaN if unknown.
struct YawRates {
  static constexpr std::int64_t step_ns = 20'000'000;
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

  std::int64_t first_ns = 0;
  std::vector<double> value;

  [[nodiscard]] std::int64_t size() const { return std::ssize(value); }
  [[nodiscard]] double at(std::int64_t k) const {
    return k < 0 || k >= size() ? unknown : value[static_cast<std::size_t>(k)];
  }
  [[nodiscard]] static double seconds(std::int64_t steps) {
    return 1e-9 * static_cast<double>(steps * step_ns);
  }
};

YawRates yaw_rates_of(const FilmMotion& motion) {
  YawRates rates{motion.frames.front().t_ns, {}};
  for (std::int64_t t = rates.first_ns; t <= motion.frames.back().t_ns; t += YawRates::step_ns) {
    const auto local = local_motion(motion, t, smoothing_ns);
    rates.value.push_back(local ? local->yaw_rate : YawRates::unknown);
  }
  return rates;
}

// The slope of a line through ψ over ±h weights the rates with a parabola, whose standard deviation
// is that of a mean over ±h √(3/5).
YawRates yaw_rates_of(const Series& gyro) {
  YawRates rates{gyro.t_ns.front(), {}};
  const auto half_ns =
      static_cast<std::int64_t>(std::sqrt(0.6) * static_cast<double>(smoothing_ns));
  std::size_t begin = 0, end = 0;
  double sum = 0.0;
  for (std::int64_t t = rates.first_ns; t <= gyro.t_ns.back(); t += YawRates::step_ns) {
    for (; end < gyro.size() && gyro.t_ns[end] <= t + half_ns; ++end) sum += gyro.value[end];
    for (; begin < end && gyro.t_ns[begin] < t - half_ns; ++begin) sum -= gyro.value[begin];
    rates.value.push_back(end > begin ? sum / static_cast<double>(end - begin) : YawRates::unknown);
  }
  return rates;
}

// The film's first sample is at this step of the gyro.
struct Shift {
  std::int64_t steps = 0;
  double agreement = -1.0;
};

// 1 - Σ (ω_film - ω_gyro)² / Σ max(ω_film², ω_gyro²) over every `stride`th sample; -1 if the
// overlap is too short or nothing turns. `sense` is -1 for a mirrored film.
double agreement_at(const YawRates& film, const YawRates& gyro, std::int64_t shift, double sense,
                    std::int64_t stride) {
  double off = 0.0, size = 0.0;
  std::int64_t count = 0;
  for (std::int64_t k = 0; k < film.size(); k += stride) {
    const double a = sense * film.at(k), b = gyro.at(shift + k);
    if (std::isnan(a) || std::isnan(b)) continue;
    off += (a - b) * (a - b);
    size += std::max(a * a, b * b);
    ++count;
  }
  const std::int64_t enough = std::max<std::int64_t>(std::min(film.size(), gyro.size()) / 3,
                                                     2'000'000'000 / YawRates::step_ns);
  return count * stride < enough || !(size > 0.0) ? -1.0 : 1.0 - off / size;
}

// The best of every `by`th shift, except those near the shift `excluded`.
Shift best_among(const YawRates& film, const YawRates& gyro, double sense, std::int64_t from,
                 std::int64_t to, std::int64_t by, const Shift* excluded = nullptr) {
  constexpr std::int64_t apart = 1'500'000'000 / YawRates::step_ns;
  Shift best;
  for (std::int64_t shift = from; shift <= to; shift += by) {
    if (excluded != nullptr && std::abs(shift - excluded->steps) < apart) continue;
    const double agreement = agreement_at(film, gyro, shift, sense, by);
    if (agreement > best.agreement) best = {shift, agreement};
  }
  return best;
}

Shift best_shift(const YawRates& film, const YawRates& gyro, double sense) {
  const Shift rough = best_among(film, gyro, sense, -film.size(), gyro.size(), coarse);
  if (rough.agreement < 0.0) return rough;
  return best_among(film, gyro, sense, rough.steps - 2 * coarse, rough.steps + 2 * coarse, 1);
}

// ω_film(t) = a ω_gyro(t - D) + b, in seconds of the film from its first sample.
Offset refine(const YawRates& film, const YawRates& gyro, const Shift& shift) {
  constexpr double step = 1e-9 * YawRates::step_ns;
  OffsetRegression regression{.range = 0.3};
  Resampled turn{.begin = -step * static_cast<double>(shift.steps), .step = step, .value = {}};
  for (const double rate : gyro.value)
    turn.value.push_back(!std::isnan(rate) ? rate : turn.value.empty() ? 0.0 : turn.value.back());
  for (std::int64_t k = 0; k < film.size(); ++k) {
    if (std::isnan(film.at(k)) || std::isnan(gyro.at(shift.steps + k))) continue;
    regression.t.push_back(step * static_cast<double>(k));
    regression.y.push_back(film.at(k));
  }
  regression.basis = {{turn}, {on_grid_of(turn, [](double) { return 1.0; })}};
  return solve(regression);
}

double high_rate_of(const YawRates& rates) {
  std::vector<double> sizes;
  for (const double value : rates.value)
    if (!std::isnan(value)) sizes.push_back(std::abs(value));
  if (sizes.empty()) return 0.0;
  const auto place = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() * 9 / 10);
  std::ranges::nth_element(sizes, place);
  return *place;
}

[[noreturn]] void refuse_unrelated(const std::string& name, const YawRates& film,
                                   const YawRates& gyro, double agreement, double mirrored) {
  if (mirrored > good_agreement)
    refuse(
        "{}: the film turns the other way than the gyro; add --y-down if the track's y points down "
        "(or omit it if it points up)",
        name);
  // A frame rate is wrong by less than a factor of 10: beyond it, the log is of another drive.
  const double ratio = high_rate_of(film) / high_rate_of(gyro);
  const bool other_rate = ratio > 0.1 && ratio < 10.0 && (ratio < 0.9 || ratio > 1.1);
  refuse(
      "{}: film and log do not overlap or are not of one drive: their yaw rates agree to {:.0f} % "
      "at best{}",
      name, 100.0 * std::max(agreement, 0.0),
      other_rate ? fmt::format("; the film turns {:.2g} times as fast as the gyro: check its frame "
                               "rate (odom identify track --fps)",
                               ratio)
                 : std::string{"; give each film its own log (--run)"});
}

// Throws for films in which the markers are too rarely visible.
void require_seen(const std::string& name, const YawRates& film) {
  const std::int64_t seen =
      std::ranges::count_if(film.value, [](double rate) { return !std::isnan(rate); });
  if (3 * seen < film.size())
    refuse(
        "{}: both markers are seen often enough in only {:.0f} s of {:.0f} s of film; track them "
        "through at least a third of it, and check that its times are in seconds",
        name, YawRates::seconds(seen), YawRates::seconds(film.size()));
}

}  // namespace

FilmAlignment align_film(const std::string& name, const FilmMotion& motion, const Series& gyro) {
  if (gyro.size() < 20)
    refuse("{}: its log has no yaw rate to align the film; map [can.signals] yaw_rate", name);
  const YawRates film = yaw_rates_of(motion), turn = yaw_rates_of(gyro);
  require_seen(name, film);
  const Shift best = best_shift(film, turn, 1.0);
  if (best.agreement < good_agreement)
    refuse_unrelated(name, film, turn, best.agreement, best_shift(film, turn, -1.0).agreement);
  const Offset refined = refine(film, turn, best);
  FilmAlignment result{.film = name};
  result.offset_ns = turn.first_ns + YawRates::step_ns * best.steps - film.first_ns -
                     std::llround(1e9 * refined.value);
  // The offset is determined in the film's middle; at its ends the clock's error adds.
  result.sigma_s = std::hypot(refined.sigma, clock_sigma * 0.5 * YawRates::seconds(film.size()));
  if (const double rate = refined.coefficients[0] - 1.0; std::abs(rate) > surprising_rate)
    add_warning(result.warnings, tools::kind("film_clock_off"), name,
                "the film turns {:.1f} % {} than the gyro", 100.0 * std::abs(rate),
                rate > 0.0 ? "faster" : "slower");
  const Shift other = best_among(film, turn, 1.0, -film.size(), turn.size(), coarse, &best);
  const std::int64_t later = other.steps - best.steps;
  if (1.0 - other.agreement < 1.5 * (1.0 - best.agreement))
    add_warning(result.warnings, tools::kind("film_start_ambiguous"), name,
                "the film may also begin {:.1f} s {}", YawRates::seconds(std::abs(later)),
                later > 0 ? "later" : "earlier");
  return result;
}

}  // namespace odomd::tools
