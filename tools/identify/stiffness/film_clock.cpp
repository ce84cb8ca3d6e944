#include "tools/identify/stiffness/film_clock.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "tools/math/least_squares.hpp"

namespace odomd::tools {
namespace {

constexpr std::int64_t half_window_ns = 200'000'000;
constexpr std::int64_t coarse = 5;  // steps

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

FilmClock fit_clock(const YawRates& film, const YawRates& gyro, std::int64_t shift) {
  Refined refined =
      refine(film, gyro, search_rate(film, gyro, shift), std::numeric_limits<double>::infinity());
  FilmClock clock;
  const double sigma = std::sqrt(refined.covariance(1, 1));
  if (std::abs(refined.placement.rate) > std::max(surprising_rate, 3.0 * sigma))
    clock.kind = FilmClock::Kind::surprising;
  else
    refined = refine(film, gyro, {refined.placement.middle_step, 0.0}, usual_rate_sigma);
  clock.rate = refined.placement.rate;
  clock.rate_sigma = std::sqrt(refined.covariance(1, 1));
  clock.begin = refined.placement.step_of(film, 0);
  // The film's begin lies n/2 steps before its middle.
  const Eigen::Vector2d to_begin{1.0, -Placement::middle(film)};
  clock.begin_sigma = std::sqrt(to_begin.dot(refined.covariance * to_begin));
  return clock;
}

}  // namespace odomd::tools
