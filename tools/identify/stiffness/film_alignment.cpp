#include "tools/identify/stiffness/film_alignment.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/identify/stiffness/film_clock.hpp"

namespace odomd::tools {
namespace {

constexpr std::int64_t coarse = 5;  // steps
constexpr double good_agreement = 0.9;

enum class Turned : std::uint8_t { as_filmed, mirrored };

// 1 - Σ (ω_film - ω_gyro)² / Σ ω_film² where the film's first sample lies on the gyro's sample
// `shift`; nothing where too little overlaps or nothing turns.
std::optional<double> agreement_at(const YawRates& film, const YawRates& gyro, std::int64_t shift,
                                   std::int64_t stride, Turned turned = Turned::as_filmed) {
  const double sign = turned == Turned::mirrored ? -1.0 : 1.0;
  double off = 0.0, size = 0.0;
  std::int64_t count = 0;
  for (std::int64_t k = 0; k < film.size(); k += stride) {
    const double a = sign * film.at(k), b = gyro.at(k + shift);
    if (std::isnan(a) || std::isnan(b)) continue;
    off += (a - b) * (a - b);
    size += std::max(a * a, b * b);
    ++count;
  }
  const std::int64_t enough = std::max<std::int64_t>(std::min(film.size(), gyro.size()) / 3,
                                                     2'000'000'000 / YawRates::step_ns);
  if (count * stride < enough || !(size > 0.0)) return std::nullopt;
  return 1.0 - off / size;
}

struct Best {
  std::int64_t shift = 0;
  double agreement = -1.0;
};

Best best_shift(const YawRates& film, const YawRates& gyro, Turned turned) {
  Best best;
  const auto look = [&](std::int64_t from, std::int64_t to, std::int64_t by) {
    for (std::int64_t shift = from; shift <= to; shift += by) {
      const auto found = agreement_at(film, gyro, shift, by, turned);
      if (found && *found > best.agreement) best = {shift, *found};
    }
  };
  look(-film.size(), gyro.size(), coarse);
  if (best.agreement < 0.0) return best;
  const std::int64_t middle = best.shift;
  best.agreement = -1.0;
  look(middle - 2 * coarse, middle + 2 * coarse, 1);
  return best;
}

// Agreement of the best shift that is not this one.
Best runner_up(const YawRates& film, const YawRates& gyro, const Best& best) {
  Best other;
  for (std::int64_t shift = -film.size(); shift <= gyro.size(); shift += coarse) {
    if (std::abs(shift - best.shift) * YawRates::step_ns < 1'500'000'000) continue;
    const auto found = agreement_at(film, gyro, shift, coarse);
    if (found && *found > other.agreement) other = {shift, *found};
  }
  return other;
}

double fastest(const YawRates& rates) {
  std::vector<double> sizes;
  for (const double value : rates.value)
    if (!std::isnan(value)) sizes.push_back(std::abs(value));
  if (sizes.empty()) return 0.0;
  const auto place = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() * 9 / 10);
  std::ranges::nth_element(sizes, place);
  return *place;
}

[[noreturn]] void fail_to_fit(const std::string& name, const YawRates& film, const YawRates& gyro,
                              double agreement, double mirrored) {
  if (mirrored > good_agreement)
    throw std::invalid_argument(name +
                                ": the film turns the other way than the gyro; add --y-down if the "
                                "track's y points down (or omit it if it points up)");
  const double ratio = fastest(film) / fastest(gyro);
  const bool other_rate = ratio > 0.0 && (ratio < 0.9 || ratio > 1.1);
  throw std::invalid_argument(fmt::format(
      "{}: film and log do not overlap or are not of one drive: their yaw rates agree to {:.0f} % "
      "at best{}",
      name, 100.0 * std::max(agreement, 0.0),
      other_rate ? fmt::format("; the film turns {:.2g} times as fast as the gyro: check its frame "
                               "rate (--fps)",
                               ratio)
                 : std::string{"; give each film its own log (--run)"}));
}

void require_turns(const std::string& name, const Series& gyro) {
  if (gyro.size() < 20)
    throw std::invalid_argument(name +
                                ": its log has no yaw rate to align the film; map "
                                "[can.signals] yaw_rate");
}

// Films with too few visible markers to compare.
void require_seen(const std::string& name, const YawRates& film) {
  const auto seen = static_cast<double>(
      std::ranges::count_if(film.value, [](double rate) { return !std::isnan(rate); }));
  const auto whole = static_cast<double>(film.size());
  if (3.0 * seen >= whole) return;
  if (seen < 0.01 * whole)
    throw std::invalid_argument(
        fmt::format("{}: by its times it is {:.0f} s long, and both markers are never seen twice "
                    "within half a second: are the times frames (--fps) or ms?",
                    name, YawRates::seconds(1) * whole));
  throw std::invalid_argument(
      fmt::format("{0}: both markers are seen often enough in only {2:.0f} s of {1:.0f} s of film; "
                  "track them through at least a third of it",
                  name, YawRates::seconds(1) * whole, YawRates::seconds(1) * seen));
}

void take_rate(const std::string& name, const FilmClock& clock, FilmAlignment& result) {
  if (clock.kind == FilmClock::Kind::surprising)
    result.warnings.push_back(
        found(diagnostics::kind("film_clock_off"), name,
              fmt::format("the film's clock runs {:.1f} % {} than the log's",
                          100.0 * std::abs(clock.rate), clock.rate > 0.0 ? "slower" : "faster")));
  result.rate = clock.rate;
  result.rate_sigma = clock.rate_sigma;
}

}  // namespace

FilmAlignment align_film(const std::string& name, const FilmMotion& motion, const Series& gyro) {
  require_turns(name, gyro);
  const YawRates film = yaw_rates_of(motion), turn = yaw_rates_of(gyro);
  require_seen(name, film);
  const Best best = best_shift(film, turn, Turned::as_filmed);
  if (best.agreement < good_agreement)
    fail_to_fit(name, film, turn, best.agreement,
                best_shift(film, turn, Turned::mirrored).agreement);

  FilmAlignment result;
  result.agreement = best.agreement;
  const FilmClock clock = fit_clock(film, turn, best.shift);
  take_rate(name, clock, result);
  result.offset_ns = turn.first_ns - film.first_ns +
                     std::llround(static_cast<double>(YawRates::step_ns) * clock.begin);
  result.sigma_s = YawRates::seconds(1) * clock.begin_sigma;
  const Best other = runner_up(film, turn, best);
  if (1.0 - other.agreement < 1.5 * (1.0 - best.agreement))
    result.warnings.push_back(
        found(diagnostics::kind("film_start_ambiguous"), name,
              fmt::format("the film may also begin {:.1f} s {}",
                          std::abs(YawRates::seconds(other.shift - best.shift)),
                          other.shift > best.shift ? "later" : "earlier")));
  return result;
}

FilmAlignment check_alignment(const std::string& name, const FilmMotion& motion, const Series& gyro,
                              std::int64_t offset_ns) {
  require_turns(name, gyro);
  const YawRates film = yaw_rates_of(motion), turn = yaw_rates_of(gyro);
  require_seen(name, film);
  const std::int64_t shift = (film.first_ns + offset_ns - turn.first_ns) / YawRates::step_ns;
  FilmAlignment result;
  result.offset_ns = offset_ns;
  result.agreement = agreement_at(film, turn, shift, 1).value_or(-1.0);
  if (result.agreement < good_agreement)
    fail_to_fit(name, film, turn, result.agreement,
                agreement_at(film, turn, shift, 1, Turned::mirrored).value_or(-1.0));
  take_rate(name, fit_clock(film, turn, shift), result);
  return result;
}

void put_on_clock_of_log(const FilmAlignment& alignment, FilmMotion& motion) {
  const std::int64_t begin = motion.frames.front().t_ns;
  for (BodyFrame& frame : motion.frames)
    frame.t_ns += std::llround(alignment.rate * static_cast<double>(frame.t_ns - begin));
}

}  // namespace odomd::tools
