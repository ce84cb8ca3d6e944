#include "tools/identify/film_alignment.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>

namespace odomd::tools {
namespace {

constexpr std::int64_t step_ns = 20'000'000;
constexpr std::int64_t half_window_ns = 200'000'000;
constexpr std::int64_t coarse = 5;  // steps
constexpr double good_agreement = 0.9;

// Yaw rates on a grid of step_ns; NaN where not known.
struct Rates {
  std::int64_t first_ns = 0;
  std::vector<double> value;

  [[nodiscard]] std::int64_t size() const { return static_cast<std::int64_t>(value.size()); }
  [[nodiscard]] double at(std::int64_t k) const {
    return k < 0 || k >= size() ? std::numeric_limits<double>::quiet_NaN()
                                : value[static_cast<std::size_t>(k)];
  }
};

Rates rates_of(const FilmMotion& motion) {
  Rates rates{motion.frames.front().t_ns, {}};
  for (std::int64_t t = rates.first_ns; t <= motion.frames.back().t_ns; t += step_ns) {
    const auto local = local_motion(motion, t, half_window_ns);
    rates.value.push_back(local ? local->yaw_rate : std::numeric_limits<double>::quiet_NaN());
  }
  return rates;
}

// The slope of a straight line through ψ over ±h weighs the rates with a parabola, whose width is
// that of a mean over ±h √(3/5).
Rates rates_of(const Series& gyro) {
  Rates rates{gyro.t_ns.front(), {}};
  const auto half_ns =
      static_cast<std::int64_t>(std::sqrt(0.6) * static_cast<double>(half_window_ns));
  std::size_t begin = 0, end = 0;
  double sum = 0.0;
  for (std::int64_t t = rates.first_ns; t <= gyro.t_ns.back(); t += step_ns) {
    for (; end < gyro.size() && gyro.t_ns[end] <= t + half_ns; ++end) sum += gyro.value[end];
    for (; begin < end && gyro.t_ns[begin] < t - half_ns; ++begin) sum -= gyro.value[begin];
    rates.value.push_back(end > begin ? sum / static_cast<double>(end - begin)
                                      : std::numeric_limits<double>::quiet_NaN());
  }
  return rates;
}

enum class Turned : std::uint8_t { as_filmed, mirrored };

// 1 - Σ (ω_film - ω_gyro)² / Σ ω_film² where the film's first sample lies on the gyro's sample
// `shift`; nothing where too little overlaps or nothing turns.
std::optional<double> agreement_at(const Rates& film, const Rates& gyro, std::int64_t shift,
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
  const std::int64_t enough =
      std::max<std::int64_t>(std::min(film.size(), gyro.size()) / 3, 2'000'000'000 / step_ns);
  if (count * stride < enough || !(size > 0.0)) return std::nullopt;
  return 1.0 - off / size;
}

struct Best {
  std::int64_t shift = 0;
  double agreement = -1.0;
};

Best best_shift(const Rates& film, const Rates& gyro, Turned turned) {
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
Best runner_up(const Rates& film, const Rates& gyro, const Best& best) {
  Best other;
  for (std::int64_t shift = -film.size(); shift <= gyro.size(); shift += coarse) {
    if (std::abs(shift - best.shift) * step_ns < 1'500'000'000) continue;
    const auto found = agreement_at(film, gyro, shift, coarse);
    if (found && *found > other.agreement) other = {shift, *found};
  }
  return other;
}

double seconds(std::int64_t ns) {
  return 1e-9 * static_cast<double>(ns);
}

// ω_film(t) = a ω_gyro(t + τ) + b, linearised in τ: [ω_gyro, 1, ω̇_gyro] [a, b, a dτ].
void refine(const Rates& film, const Rates& gyro, std::int64_t shift, FilmAlignment& result) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  double total = 0.0, count = 0.0;
  for (std::int64_t k = 0; k < film.size(); ++k) {
    const double a = film.at(k);
    const Eigen::Vector3d row{
        gyro.at(k + shift), 1.0,
        (gyro.at(k + shift + 1) - gyro.at(k + shift - 1)) / (2.0 * seconds(step_ns))};
    if (std::isnan(a) || !row.allFinite()) continue;
    normal += row * row.transpose();
    right += row * a;
    total += a * a;
    count += 1.0;
  }
  const double scale = normal.diagonal().maxCoeff();
  const Eigen::Matrix3d inverse = (normal + 1e-9 * scale * Eigen::Matrix3d::Identity()).inverse();
  const Eigen::Vector3d solution = inverse * right;
  const double moved = solution[2] / solution[0];
  // Neighbouring samples share what their windows share: one of them in ten counts.
  const double variance =
      10.0 * std::max(total - solution.dot(right), 1e-12 * total) / std::max(count - 3.0, 1.0);
  result.sigma_s = std::sqrt(variance * inverse(2, 2)) / std::abs(solution[0]);
  if (std::abs(moved) < 2.0 * seconds(step_ns)) result.offset_ns += std::llround(1e9 * moved);
}

double fastest(const Rates& rates) {
  std::vector<double> sizes;
  for (const double value : rates.value)
    if (!std::isnan(value)) sizes.push_back(std::abs(value));
  if (sizes.empty()) return 0.0;
  const auto place = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() * 9 / 10);
  std::ranges::nth_element(sizes, place);
  return *place;
}

[[noreturn]] void fail_to_fit(const std::string& name, const Rates& film, const Rates& gyro,
                              double agreement, double mirrored) {
  if (mirrored > good_agreement)
    throw std::invalid_argument(
        name +
        ": the film turns the other way than the gyro; add --y-down where the track's y "
        "points down (or leave it out where it points up)");
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
                                ": its log has no yaw rate to align the film by; bind "
                                "[can.signals] yaw_rate");
}

}  // namespace

FilmAlignment align_film(const std::string& name, const FilmMotion& motion, const Series& gyro) {
  require_turns(name, gyro);
  const Rates film = rates_of(motion), turn = rates_of(gyro);
  const Best best = best_shift(film, turn, Turned::as_filmed);
  if (best.agreement < good_agreement)
    fail_to_fit(name, film, turn, best.agreement,
                best_shift(film, turn, Turned::mirrored).agreement);

  FilmAlignment result;
  result.agreement = best.agreement;
  result.offset_ns = turn.first_ns + best.shift * step_ns - film.first_ns;
  refine(film, turn, best.shift, result);
  const Best other = runner_up(film, turn, best);
  if (1.0 - other.agreement < 1.5 * (1.0 - best.agreement))
    result.warnings.push_back(fmt::format(
        "{}: the film may as well begin {:.1f} s {}; if it does, say so by --time-offset, or film "
        "the start from standing too",
        name, std::abs(seconds((other.shift - best.shift) * step_ns)),
        other.shift > best.shift ? "later" : "earlier"));
  return result;
}

FilmAlignment check_alignment(const std::string& name, const FilmMotion& motion, const Series& gyro,
                              std::int64_t offset_ns) {
  require_turns(name, gyro);
  const Rates film = rates_of(motion), turn = rates_of(gyro);
  const std::int64_t shift = (film.first_ns + offset_ns - turn.first_ns) / step_ns;
  FilmAlignment result;
  result.offset_ns = offset_ns;
  result.agreement = agreement_at(film, turn, shift, 1).value_or(-1.0);
  if (result.agreement < good_agreement)
    fail_to_fit(name, film, turn, result.agreement,
                agreement_at(film, turn, shift, 1, Turned::mirrored).value_or(-1.0));
  return result;
}

}  // namespace odomd::tools
