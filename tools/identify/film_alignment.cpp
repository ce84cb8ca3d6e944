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

// Where the film lies on the gyro: its sample k at gyro step `middle_step` + (k - n/2) (1 + rate).
struct Placement {
  double middle_step = 0.0;
  double rate = 0.0;

  [[nodiscard]] double step_of(const Rates& film, std::int64_t k) const {
    return middle_step + (1.0 + rate) * (static_cast<double>(k) - middle(film));
  }
  static double middle(const Rates& film) { return 0.5 * static_cast<double>(film.size() - 1); }
};

struct Turn {
  double rate = 0.0, slope = 0.0;  // ω [rad/s], ω̇ by steps
};

Turn between(const Rates& gyro, double step) {
  const auto before = static_cast<std::int64_t>(std::floor(step));
  const double part = step - static_cast<double>(before);
  const double rate = gyro.at(before) + part * (gyro.at(before + 1) - gyro.at(before));
  return {rate, 0.5 * (gyro.at(before + 1) - gyro.at(before - 1)) +
                    0.5 * part *
                        (gyro.at(before + 2) - gyro.at(before + 1) - gyro.at(before) +
                         gyro.at(before - 1))};
}

double squares_at(const Rates& film, const Rates& gyro, const Placement& placement) {
  double off = 0.0;
  std::int64_t count = 0;
  for (std::int64_t k = 0; k < film.size(); k += coarse) {
    const double difference = film.at(k) - between(gyro, placement.step_of(film, k)).rate;
    if (std::isnan(difference)) continue;
    off += difference * difference;
    ++count;
  }
  return count * coarse * 3 < film.size() ? std::numeric_limits<double>::infinity()
                                          : off / static_cast<double>(count);
}

// Among clocks so different that the film's ends move by up to 4 s, the best one, to 0.2 s there.
Placement search_rate(const Rates& film, const Rates& gyro, std::int64_t shift) {
  const double half = Placement::middle(film);
  const Placement constant{static_cast<double>(shift) + half, 0.0};
  Placement best = constant;
  double least = squares_at(film, gyro, constant);
  constexpr double farthest = 4e9 / step_ns, by = 0.2e9 / step_ns, largest = 0.08;
  const double end = std::min(farthest, largest * half);
  const double slack = farthest;
  for (double at_end = -end; at_end <= end; at_end += by)
    for (double moved = -slack; moved <= slack; moved += 0.5 * by) {
      const Placement placement{constant.middle_step + moved, at_end / half};
      const double squares = squares_at(film, gyro, placement);
      if (squares >= least) continue;
      least = squares;
      best = placement;
    }
  return best;
}

// ω_film(t) = a ω_gyro(t + τ + ε (t - t_mid)) + b, linearised in τ and ε: the factors of
// [ω_gyro, 1, ω̇_gyro, (t - t_mid) ω̇_gyro] are [a, b, a dτ, a dε].
struct Refined {
  Placement placement;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // of dτ [steps] and dε
};

Refined refine(const Rates& film, const Rates& gyro, Placement placement, double prior_rate_sigma) {
  Refined refined{placement, {}};
  for (int iteration = 0; iteration < 8; ++iteration) {
    Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
    Eigen::Vector4d right = Eigen::Vector4d::Zero();
    double total = 0.0, count = 0.0;
    for (std::int64_t k = 0; k < film.size(); ++k) {
      const double seen = film.at(k);
      const Turn turn = between(gyro, refined.placement.step_of(film, k));
      const Eigen::Vector4d row{turn.rate, 1.0, turn.slope,
                                (static_cast<double>(k) - Placement::middle(film)) * turn.slope};
      if (std::isnan(seen) || !row.allFinite()) continue;
      normal += row * row.transpose();
      right += row * seen;
      total += seen * seen;
      count += 1.0;
    }
    const Eigen::Vector4d scale = normal.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const auto solve = [&](const Eigen::Matrix4d& matrix) -> Eigen::Matrix4d {
      const Eigen::Matrix4d scaled = scale.asDiagonal() * matrix * scale.asDiagonal();
      return scale.asDiagonal() * (scaled + 1e-9 * Eigen::Matrix4d::Identity()).inverse() *
             scale.asDiagonal();
    };
    const Eigen::Vector4d free = solve(normal) * right;
    // Neighbouring samples share what their windows share: one of them in ten counts.
    const double variance =
        10.0 * std::max(total - free.dot(right), 1e-12 * total) / std::max(count - 4.0, 1.0);
    const double a = free[0];
    if (std::isfinite(prior_rate_sigma)) {
      const double weight = variance / (a * a * prior_rate_sigma * prior_rate_sigma);
      normal(3, 3) += weight;
      right[3] -= weight * a * refined.placement.rate;
    }
    const Eigen::Matrix4d inverse = solve(normal);
    const Eigen::Vector4d found = inverse * right;
    refined.covariance = variance / (a * a) * inverse.bottomRightCorner<2, 2>();
    const double moved = found[2] / a, faster = found[3] / a;
    constexpr double farthest = 25.0;  // steps: beyond them no line holds
    if (!(std::abs(moved) < farthest)) break;
    refined.placement.middle_step += moved;
    refined.placement.rate += faster;
    if (std::abs(moved) < 1e-4 && std::abs(faster) < 1e-8) break;
  }
  return refined;
}

// Two clocks of quartz, and the 29.97 frames of a film of 30.
constexpr double usual_rate_sigma = 1e-3;
constexpr double surprising_rate = 3e-3;

void settle_clock(const std::string& name, const Rates& film, const Rates& gyro, std::int64_t shift,
                  FilmAlignment& result) {
  Refined refined =
      refine(film, gyro, search_rate(film, gyro, shift), std::numeric_limits<double>::infinity());
  const double sigma = std::sqrt(refined.covariance(1, 1));
  const double rate = refined.placement.rate;
  if (std::abs(rate) > std::max(surprising_rate, 3.0 * sigma)) {
    result.warnings.push_back(fmt::format(
        "{}: the film's clock runs {:.1f} % {} than the log's: frames dropped, or another frame "
        "rate (--fps)? Its times are stretched to fit",
        name, 100.0 * std::abs(rate), rate > 0.0 ? "slower" : "faster"));
  } else {
    refined = refine(film, gyro, {refined.placement.middle_step, 0.0}, usual_rate_sigma);
  }
  result.rate = refined.placement.rate;
  result.rate_sigma = std::sqrt(refined.covariance(1, 1));
  // The film's begin lies n/2 steps before its middle.
  const Eigen::Vector2d to_begin{1.0, -Placement::middle(film)};
  result.sigma_s = seconds(step_ns) * std::sqrt(to_begin.dot(refined.covariance * to_begin));
  result.offset_ns =
      gyro.first_ns - film.first_ns +
      std::llround(static_cast<double>(step_ns) * refined.placement.step_of(film, 0));
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

// What is too rarely seen to be held against anything.
void require_seen(const std::string& name, const Rates& film) {
  const auto seen = static_cast<double>(
      std::ranges::count_if(film.value, [](double rate) { return !std::isnan(rate); }));
  const auto whole = static_cast<double>(film.size());
  if (3.0 * seen >= whole) return;
  throw std::invalid_argument(fmt::format(
      "{}: of {:.0f} s of film both markers are seen often enough in {:.0f} s only; track them "
      "through at least a third of it",
      name, seconds(step_ns) * whole, seconds(step_ns) * seen));
}

FilmAlignment align_film(const std::string& name, const FilmMotion& motion, const Series& gyro) {
  require_turns(name, gyro);
  const Rates film = rates_of(motion), turn = rates_of(gyro);
  require_seen(name, film);
  const Best best = best_shift(film, turn, Turned::as_filmed);
  if (best.agreement < good_agreement)
    fail_to_fit(name, film, turn, best.agreement,
                best_shift(film, turn, Turned::mirrored).agreement);

  FilmAlignment result;
  result.agreement = best.agreement;
  settle_clock(name, film, turn, best.shift, result);
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
  require_seen(name, film);
  const std::int64_t shift = (film.first_ns + offset_ns - turn.first_ns) / step_ns;
  FilmAlignment result;
  result.offset_ns = offset_ns;
  result.agreement = agreement_at(film, turn, shift, 1).value_or(-1.0);
  if (result.agreement < good_agreement)
    fail_to_fit(name, film, turn, result.agreement,
                agreement_at(film, turn, shift, 1, Turned::mirrored).value_or(-1.0));
  settle_clock(name, film, turn, shift, result);
  result.offset_ns = offset_ns;
  result.sigma_s = 0.0;
  return result;
}

void put_on_clock_of_log(const FilmAlignment& alignment, FilmMotion& motion) {
  const std::int64_t begin = motion.frames.front().t_ns;
  for (BodyFrame& frame : motion.frames)
    frame.t_ns += std::llround(alignment.rate * static_cast<double>(frame.t_ns - begin));
}

}  // namespace odomd::tools
