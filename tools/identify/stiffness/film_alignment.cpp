#include "tools/diagnostics/kinds.hpp"
#include "tools/identify/stiffness/film.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "tools/identify/common/refuse.hpp"
#include "tools/math/least_squares.hpp"

namespace odomd::tools {
namespace {

constexpr std::int64_t coarse = 5;  // steps
constexpr double good_agreement = 0.9;

// Where the film lies on the gyro: its sample k at gyro step `middle_step` + (k - n/2) (1 + rate).
struct Placement {
  double middle_step = 0.0;
  double rate = 0.0;

  [[nodiscard]] double step_of(const YawRates& film, std::int64_t k) const {
    return middle_step + (1.0 + rate) * (static_cast<double>(k) - middle(film));
  }
  static double middle(const YawRates& film) { return 0.5 * static_cast<double>(film.size() - 1); }
};

struct Turn {
  double rate = 0.0, slope = 0.0;  // ω [rad/s], ω̇ by steps
};

Turn between(const YawRates& gyro, double step) {
  const auto before = static_cast<std::int64_t>(std::floor(step));
  const double part = step - static_cast<double>(before);
  const double rate = gyro.at(before) + part * (gyro.at(before + 1) - gyro.at(before));
  return {rate, 0.5 * (gyro.at(before + 1) - gyro.at(before - 1)) +
                    0.5 * part *
                        (gyro.at(before + 2) - gyro.at(before + 1) - gyro.at(before) +
                         gyro.at(before - 1))};
}

double squares_at(const YawRates& film, const YawRates& gyro, const Placement& placement) {
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
Placement search_rate(const YawRates& film, const YawRates& gyro, std::int64_t shift) {
  const double half = Placement::middle(film);
  const Placement constant{static_cast<double>(shift) + half, 0.0};
  Placement best = constant;
  double least = squares_at(film, gyro, constant);
  constexpr double farthest = 4e9 / YawRates::step_ns, by = 0.2e9 / YawRates::step_ns,
                   largest = 0.08;
  const double end = std::min(farthest, largest * half);
  const auto ends = static_cast<int>(2.0 * end / by), moves = static_cast<int>(4.0 * farthest / by);
  for (int i = 0; i <= ends; ++i) {
    const double at_end = by * i - end;
    for (int j = 0; j <= moves; ++j) {
      const double moved = 0.5 * by * j - farthest;
      const Placement placement{constant.middle_step + moved, at_end / half};
      const double squares = squares_at(film, gyro, placement);
      if (squares >= least) continue;
      least = squares;
      best = placement;
    }
  }
  return best;
}

// ω_film(t) = a ω_gyro(t + τ + ε (t - t_mid)) + b, linearised in τ and ε: the factors of
// [ω_gyro, 1, ω̇_gyro, (t - t_mid) ω̇_gyro] are [a, b, a dτ, a dε].
struct Refined {
  Placement placement;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // of dτ [steps] and dε
};

Refined refine(const YawRates& film, const YawRates& gyro, const Placement& placement,
               double prior_rate_sigma) {
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
    const Eigen::Vector4d free = inverse_of(normal) * right;
    // Neighbouring samples share what their windows share: one of them in ten counts.
    const double variance =
        10.0 * std::max(total - free.dot(right), 1e-12 * total) / std::max(count - 4.0, 1.0);
    const double a = free[0];
    const double weight = variance / (a * a * prior_rate_sigma * prior_rate_sigma);
    normal(3, 3) += weight;
    right[3] -= weight * a * refined.placement.rate;
    const Eigen::Matrix4d inverse = inverse_of(normal);
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

/// From a shift that is good to about a second. The gyro's scale and bias are left free. A rate
/// within 0.3 % is held to 0.1 %, as clocks and nominal frame rates are.
FilmAlignment fit_clock(const std::string& name, const YawRates& film, const YawRates& gyro,
                        std::int64_t shift) {
  FilmAlignment result;
  Refined refined =
      refine(film, gyro, search_rate(film, gyro, shift), std::numeric_limits<double>::infinity());
  const double rate = refined.placement.rate;
  if (std::abs(rate) > std::max(surprising_rate, 3.0 * std::sqrt(refined.covariance(1, 1))))
    result.warnings.push_back(
        found(tools::kind("film_clock_off"), name,
              fmt::format("the film's clock runs {:.1f} % {} than the log's",
                          100.0 * std::abs(rate), rate > 0.0 ? "slower" : "faster")));
  else
    refined = refine(film, gyro, {refined.placement.middle_step, 0.0}, usual_rate_sigma);
  result.rate = refined.placement.rate;
  result.rate_sigma = std::sqrt(refined.covariance(1, 1));
  const double begin = refined.placement.step_of(film, 0);
  result.offset_ns =
      gyro.first_ns - film.first_ns + std::llround(static_cast<double>(YawRates::step_ns) * begin);
  // The film's begin lies n/2 steps before its middle.
  const Eigen::Vector2d to_begin{1.0, -Placement::middle(film)};
  result.sigma_s = YawRates::seconds(1) * std::sqrt(to_begin.dot(refined.covariance * to_begin));
  return result;
}

struct Best {
  std::int64_t shift = 0;
  double agreement = -1.0;
};

// 1 - Σ (ω_film - ω_gyro)² / Σ ω_film² where the film's first sample lies on the gyro's sample
// `shift`; -1 where too little overlaps or nothing turns. `sense` is -1 for a mirrored film.
double agreement_at(const YawRates& film, const YawRates& gyro, double sense, std::int64_t shift,
                    std::int64_t stride) {
  double off = 0.0, size = 0.0;
  std::int64_t count = 0;
  for (std::int64_t k = 0; k < film.size(); k += stride) {
    const double a = sense * film.at(k), b = gyro.at(k + shift);
    if (std::isnan(a) || std::isnan(b)) continue;
    off += (a - b) * (a - b);
    size += std::max(a * a, b * b);
    ++count;
  }
  const std::int64_t enough = std::max<std::int64_t>(std::min(film.size(), gyro.size()) / 3,
                                                     2'000'000'000 / YawRates::step_ns);
  return count * stride < enough || !(size > 0.0) ? -1.0 : 1.0 - off / size;
}

// Among every `by`th shift, without those about a place that is taken.
Best best_among(const YawRates& film, const YawRates& gyro, double sense, std::int64_t from,
                std::int64_t to, std::int64_t by, const Best* taken = nullptr) {
  constexpr std::int64_t apart = 1'500'000'000 / YawRates::step_ns;
  Best best;
  for (std::int64_t shift = from; shift <= to; shift += by) {
    if (taken != nullptr && std::abs(shift - taken->shift) < apart) continue;
    const double agreement = agreement_at(film, gyro, sense, shift, by);
    if (agreement > best.agreement) best = {shift, agreement};
  }
  return best;
}

Best best_shift(const YawRates& film, const YawRates& gyro, double sense) {
  const Best rough = best_among(film, gyro, sense, -film.size(), gyro.size(), coarse);
  if (rough.agreement < 0.0) return rough;
  return best_among(film, gyro, sense, rough.shift - 2 * coarse, rough.shift + 2 * coarse, 1);
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
    refuse(
        "{}: the film turns the other way than the gyro; add --y-down if the track's y points down "
        "(or omit it if it points up)",
        name);
  const double ratio = fastest(film) / fastest(gyro);
  const bool other_rate = ratio > 0.0 && (ratio < 0.9 || ratio > 1.1);
  refuse(
      "{}: film and log do not overlap or are not of one drive: their yaw rates agree to {:.0f} % "
      "at best{}",
      name, 100.0 * std::max(agreement, 0.0),
      other_rate ? fmt::format("; the film turns {:.2g} times as fast as the gyro: check its frame "
                               "rate (--fps)",
                               ratio)
                 : std::string{"; give each film its own log (--run)"});
}

// Films with too few visible markers to compare.
void require_seen(const std::string& name, const YawRates& film) {
  const auto seen = static_cast<double>(
      std::ranges::count_if(film.value, [](double rate) { return !std::isnan(rate); }));
  const auto whole = static_cast<double>(film.size());
  if (3.0 * seen >= whole) return;
  if (seen < 0.01 * whole)
    refuse(
        "{}: by its times it is {:.0f} s long, and both markers are never seen twice "
        "within half a second: are the times frames (--fps) or ms?",
        name, YawRates::seconds(1) * whole);
  refuse(
      "{0}: both markers are seen often enough in only {2:.0f} s of {1:.0f} s of film; "
      "track them through at least a third of it",
      name, YawRates::seconds(1) * whole, YawRates::seconds(1) * seen);
}

}  // namespace

FilmAlignment align_film(const std::string& name, const FilmMotion& motion, const Series& gyro,
                         std::optional<std::int64_t> offset_ns) {
  if (gyro.size() < 20)
    refuse("{}: its log has no yaw rate to align the film; map [can.signals] yaw_rate", name);
  const YawRates film = yaw_rates_of(motion), turn = yaw_rates_of(gyro);
  require_seen(name, film);
  const auto best_with = [&](double sense) {
    if (!offset_ns) return best_shift(film, turn, sense);
    const std::int64_t shift = (film.first_ns + *offset_ns - turn.first_ns) / YawRates::step_ns;
    return Best{shift, agreement_at(film, turn, sense, shift, 1)};
  };
  const Best best = best_with(1.0);
  if (best.agreement < good_agreement)
    fail_to_fit(name, film, turn, best.agreement, best_with(-1.0).agreement);
  FilmAlignment result = fit_clock(name, film, turn, best.shift);
  result.agreement = best.agreement;
  if (offset_ns) {
    result.offset_ns = *offset_ns;
    result.sigma_s = 0.0;
    return result;
  }
  const Best other = best_among(film, turn, 1.0, -film.size(), turn.size(), coarse, &best);
  if (1.0 - other.agreement < 1.5 * (1.0 - best.agreement))
    result.warnings.push_back(
        found(tools::kind("film_start_ambiguous"), name,
              fmt::format("the film may also begin {:.1f} s {}",
                          std::abs(YawRates::seconds(other.shift - best.shift)),
                          other.shift > best.shift ? "later" : "earlier")));
  return result;
}

void put_on_clock_of_log(const FilmAlignment& alignment, FilmMotion& motion) {
  const std::int64_t begin = motion.frames.front().t_ns;
  for (BodyFrame& frame : motion.frames)
    frame.t_ns += std::llround(alignment.rate * static_cast<double>(frame.t_ns - begin));
}

}  // namespace odomd::tools
