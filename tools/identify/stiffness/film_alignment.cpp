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

// Position of the film: its sample k is at gyro step `middle_step` + (k - n/2) (1 + rate).
struct Placement {
  double middle_step = 0.0;
  double rate = 0.0;
  double agreement = -1.0;

  [[nodiscard]] double step_of(const YawRates& film, std::int64_t k) const {
    return middle_step + (1.0 + rate) * (static_cast<double>(k) - middle(film));
  }
  static double middle(const YawRates& film) { return 0.5 * static_cast<double>(film.size() - 1); }
};

double between(const YawRates& gyro, double step) {
  const double before = std::floor(step);
  const auto k = static_cast<std::int64_t>(before);
  return gyro.at(k) + (step - before) * (gyro.at(k + 1) - gyro.at(k));
}

// 1 - Σ (ω_film - ω_gyro)² / Σ max(ω_film², ω_gyro²); -1 if the overlap is too short or nothing
// turns. `sense` is -1 for a mirrored film.
Placement with_agreement(const YawRates& film, const YawRates& gyro, Placement placement,
                         double sense, std::int64_t stride) {
  double off = 0.0, size = 0.0;
  std::int64_t count = 0;
  for (std::int64_t k = 0; k < film.size(); k += stride) {
    const double a = sense * film.at(k), b = between(gyro, placement.step_of(film, k));
    if (std::isnan(a) || std::isnan(b)) continue;
    off += (a - b) * (a - b);
    size += std::max(a * a, b * b);
    ++count;
  }
  const std::int64_t enough = std::max<std::int64_t>(std::min(film.size(), gyro.size()) / 3,
                                                     2'000'000'000 / YawRates::step_ns);
  placement.agreement = count * stride < enough || !(size > 0.0) ? -1.0 : 1.0 - off / size;
  return placement;
}

// The film's first sample at the gyro's sample `shift`, with equal clock rates.
Placement shifted(const YawRates& film, const YawRates& gyro, std::int64_t shift, double sense,
                  std::int64_t stride) {
  return with_agreement(film, gyro, {static_cast<double>(shift) + Placement::middle(film)}, sense,
                        stride);
}

// Grid search over shifts, and over clock rates that move the film's ends by 4 s in 0.2 s steps.
Placement search_rate(const YawRates& film, const YawRates& gyro, const Placement& constant) {
  const double half = Placement::middle(film);
  Placement best = with_agreement(film, gyro, constant, 1.0, coarse);
  constexpr double farthest = 4e9 / YawRates::step_ns, by = 0.2e9 / YawRates::step_ns,
                   largest = 0.08;
  const double end = std::min(farthest, largest * half);
  const auto ends = static_cast<int>(2.0 * end / by), moves = static_cast<int>(4.0 * farthest / by);
  for (int i = 0; i <= ends; ++i)
    for (int j = 0; j <= moves; ++j) {
      const Placement other{constant.middle_step + 0.5 * by * j - farthest, (by * i - end) / half};
      const Placement seen = with_agreement(film, gyro, other, 1.0, coarse);
      if (seen.agreement > best.agreement) best = seen;
    }
  return best;
}

struct Refined {
  Placement placement;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // of the middle step and the rate
};

// Fits ω_film(t) = a ω_gyro(t') + b, with t' from the placement: a, b and the placement.
Refined refine(const YawRates& film, const YawRates& gyro, const Placement& placement,
               double prior_rate_sigma) {
  constexpr double unknown = std::numeric_limits<double>::infinity();
  LeastSquares problem{.start = Eigen::Vector4d{1.0, 0.0, placement.middle_step, placement.rate},
                       .expected = Eigen::Vector4d::Zero(),
                       .prior_sigma = Eigen::Vector4d::Constant(unknown),
                       .noise = 1.0,
                       .huber = no_huber,
                       .together = 10.0,  // samples that share a smoothing window
                       .enough = 1e-12};
  problem.step = Eigen::Vector4d{1e-4, 1e-4, 0.1, 0.1 / Placement::middle(film)};
  // Samples that overlap before the fit stay in it: none drops out of the log to improve the fit.
  const auto in_log = [&](const Placement& here, std::int64_t k) {
    return std::clamp(here.step_of(film, k), 0.0, static_cast<double>(gyro.size()) - 1.001);
  };
  const auto overlaps = [&](std::int64_t k) {
    return placement.step_of(film, k) == in_log(placement, k);
  };
  problem.residuals = [&](const Eigen::VectorXd& p) -> Eigen::VectorXd {
    const Placement here{p[2], p[3]};
    return Eigen::VectorXd::NullaryExpr(film.size(), [&](Eigen::Index k) {
      const double off = film.at(k) - p[0] * between(gyro, in_log(here, k)) - p[1];
      return std::isnan(off) || !overlaps(k) ? 0.0 : off;
    });
  };
  problem.start = solve(problem).parameters;
  const Eigen::VectorXd rest = problem.residuals(problem.start);
  const auto count = static_cast<double>((rest.array() != 0.0).count());
  problem.noise = std::max(rest.norm() / std::sqrt(std::max(count - 4.0, 1.0)), 1e-9);
  problem.prior_sigma[3] = prior_rate_sigma;
  const LeastSquaresSolution found = solve(problem);
  return {{found.parameters[2], found.parameters[3]}, found.inverse.bottomRightCorner<2, 2>()};
}

// Covers two quartz clocks, and a film of 29.97 frames per second taken for 30.
constexpr double usual_rate_sigma = 1e-3;
constexpr double surprising_rate = 3e-3;

/// Fits the clock from a shift that is accurate to about a second. The gyro's scale and bias are
/// free. A rate within 0.3 % has a prior of 0.1 %, as clocks and nominal frame rates have.
FilmAlignment fit_clock(const std::string& name, const YawRates& film, const YawRates& gyro,
                        const Placement& placement) {
  FilmAlignment result;
  Refined refined = refine(film, gyro, search_rate(film, gyro, placement),
                           std::numeric_limits<double>::infinity());
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
  // The film's start is n/2 steps before its middle.
  const Eigen::Vector2d to_begin{1.0, -Placement::middle(film)};
  result.sigma_s = YawRates::seconds(1) * std::sqrt(to_begin.dot(refined.covariance * to_begin));
  return result;
}

// The best of every `by`th shift, except those near the placement `taken`.
Placement best_among(const YawRates& film, const YawRates& gyro, double sense, std::int64_t from,
                     std::int64_t to, std::int64_t by, const Placement* taken = nullptr) {
  constexpr double apart = 1.5e9 / YawRates::step_ns;
  Placement best;
  for (std::int64_t shift = from; shift <= to; shift += by) {
    const Placement seen = shifted(film, gyro, shift, sense, by);
    if (taken != nullptr && std::abs(seen.middle_step - taken->middle_step) < apart) continue;
    if (seen.agreement > best.agreement) best = seen;
  }
  return best;
}

Placement best_shift(const YawRates& film, const YawRates& gyro, double sense) {
  const Placement rough = best_among(film, gyro, sense, -film.size(), gyro.size(), coarse);
  if (rough.agreement < 0.0) return rough;
  const auto shift = std::llround(rough.step_of(film, 0));
  return best_among(film, gyro, sense, shift - 2 * coarse, shift + 2 * coarse, 1);
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

// Throws for films in which the markers are too rarely visible.
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
    return shifted(film, turn, shift, sense, 1);
  };
  const Placement best = best_with(1.0);
  if (best.agreement < good_agreement)
    fail_to_fit(name, film, turn, best.agreement, best_with(-1.0).agreement);
  FilmAlignment result = fit_clock(name, film, turn, best);
  result.agreement = best.agreement;
  if (offset_ns) {
    result.offset_ns = *offset_ns;
    result.sigma_s = 0.0;
    return result;
  }
  const Placement other = best_among(film, turn, 1.0, -film.size(), turn.size(), coarse, &best);
  const double later = other.middle_step - best.middle_step;
  if (1.0 - other.agreement < 1.5 * (1.0 - best.agreement))
    result.warnings.push_back(found(tools::kind("film_start_ambiguous"), name,
                                    fmt::format("the film may also begin {:.1f} s {}",
                                                1e-9 * YawRates::step_ns * std::abs(later),
                                                later > 0.0 ? "later" : "earlier")));
  return result;
}

void put_on_clock_of_log(const FilmAlignment& alignment, FilmMotion& motion) {
  const std::int64_t begin = motion.frames.front().t_ns;
  for (BodyFrame& frame : motion.frames)
    frame.t_ns += std::llround(alignment.rate * static_cast<double>(frame.t_ns - begin));
}

}  // namespace odomd::tools
