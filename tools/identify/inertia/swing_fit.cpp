#include "tools/identify/inertia/bifilar.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "tools/diagnostics/kinds.hpp"
#include "tools/identify/common/refuse.hpp"
#include "tools/math/least_squares.hpp"

namespace odomd::tools {
namespace {

using std::numbers::pi;

struct Record {
  std::vector<double> t;  // [s], from the first sample of the log
  std::vector<double> rate;
};

/// An approximate value suffices: the fit needs it only for the small effect of the body's lift.
constexpr double gravity = 9.81;

/// Beyond these limits the record must be in other units.
constexpr double slowest = 100.0;    // period [s]
constexpr double widest = 0.5 * pi;  // amplitude [rad]

enum Unknown : Eigen::Index { log_period, viscous, quadratic, angle, rate, bias, unknown_count };
using Unknowns = Eigen::Matrix<double, unknown_count, 1>;

/// Computes θ" of the pendulum: the equation in bifilar.hpp, divided by J.
class Motion {
 public:
  Motion(const Bifilar& pendulum, const Unknowns& x)
      : p_(pendulum.product()), straight_(pendulum.height()), c_(x[viscous]), d_(x[quadratic]) {
    const double omega = 2.0 * pi / std::exp(x[log_period]);
    stiffness_ = omega * omega * straight_ / p_;  // m g / J
  }

  [[nodiscard]] double acceleration(double theta, double theta_dot) const {
    const double sine = std::sin(theta), cosine = std::cos(theta);
    const double h = std::sqrt(std::max(straight_ * straight_ - 2.0 * p_ * (1.0 - cosine), 1e-12));
    const double z1 = p_ * sine / h;
    const double z2 = (p_ * cosine + z1 * z1) / h;
    const double lift = stiffness_ / gravity;  // m / J
    const double force = stiffness_ * z1 + lift * z1 * z2 * theta_dot * theta_dot + c_ * theta_dot +
                         d_ * std::fabs(theta_dot) * theta_dot;
    return -force / (1.0 + lift * z1 * z1);
  }

  void advance(double dt, double& theta, double& theta_dot) const {
    const double k1 = acceleration(theta, theta_dot);
    const double v2 = theta_dot + 0.5 * dt * k1;
    const double k2 = acceleration(theta + 0.5 * dt * theta_dot, v2);
    const double v3 = theta_dot + 0.5 * dt * k2;
    const double k3 = acceleration(theta + 0.5 * dt * v2, v3);
    const double v4 = theta_dot + dt * k3;
    const double k4 = acceleration(theta + dt * v3, v4);
    theta += dt / 6.0 * (theta_dot + 2.0 * v2 + 2.0 * v3 + v4);
    theta_dot += dt / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  }

 private:
  double p_, straight_, c_, d_, stiffness_ = 0.0;
};

/// Part of a record: samples [begin, end).
struct Section {
  std::size_t begin = 0;
  std::size_t end = 0;
  [[nodiscard]] std::size_t size() const { return end - begin; }
};

Eigen::VectorXd modelled(const Record& record, Section section, const Bifilar& pendulum,
                         const Unknowns& x) {
  const Motion motion(pendulum, x);
  const double longest = std::exp(x[log_period]) / 100.0;
  double theta = x[angle], theta_dot = x[rate];
  Eigen::VectorXd rates(static_cast<Eigen::Index>(section.size()));
  for (std::size_t i = section.begin; i < section.end; ++i) {
    if (i > section.begin) {
      const double dt = record.t[i] - record.t[i - 1];
      const int steps = std::max(1, static_cast<int>(std::ceil(dt / longest)));
      for (int step = 0; step < steps; ++step) motion.advance(dt / steps, theta, theta_dot);
    }
    rates[static_cast<Eigen::Index>(i - section.begin)] = theta_dot + x[bias];
  }
  return rates;
}

struct Fitted {
  Unknowns x = Unknowns::Zero();
  Eigen::VectorXd residuals;
  double period_sigma = 0.0;  // if residuals are white [s]
};

/// Fits a section; nothing if the fit does not converge.
std::optional<Fitted> fit(const Record& record, Section section, const Bifilar& pendulum,
                          const Unknowns& start) {
  const Eigen::Map<const Eigen::VectorXd> measured(&record.rate[section.begin],
                                                   static_cast<Eigen::Index>(section.size()));
  const double peak = measured.cwiseAbs().maxCoeff();
  constexpr double unknown = std::numeric_limits<double>::infinity();
  LeastSquares problem{.start = start,
                       .expected = Unknowns::Zero(),
                       .prior_sigma = Unknowns::Constant(unknown),
                       .huber = no_huber,
                       .enough = 1e-6,
                       .iterations = 60};
  problem.step = (Unknowns() << 1e-6, 1e-6, 1e-6, 1e-6, 1e-6 * peak, 1e-6 * peak).finished();
  problem.residuals = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
    return measured - modelled(record, section, pendulum, x);
  };
  const LeastSquaresSolution found = solve(problem);
  if (!found.settled || !found.parameters.allFinite()) return std::nullopt;
  Fitted fitted{.x = found.parameters, .residuals = problem.residuals(found.parameters)};
  const double variance =
      fitted.residuals.squaredNorm() / static_cast<double>(measured.size() - unknown_count);
  fitted.period_sigma =
      std::exp(fitted.x[log_period]) * std::sqrt(found.inverse(0, 0) * variance) / found.noise;
  return fitted;
}

/// Fits a few swings first, then twice as many, and so on: a fit of the whole record at once might
/// be wrong by one swing.
std::optional<Fitted> fit_by_and_by(const Record& record, Section section, const Bifilar& pendulum,
                                    Unknowns guess) {
  double span = 4.0 * std::exp(guess[log_period]);
  while (true) {
    const double until = record.t[section.begin] + span;
    const auto past = std::ranges::lower_bound(record.t, until);
    const Section part{section.begin,
                       std::min(section.end, static_cast<std::size_t>(past - record.t.begin()))};
    auto fitted = fit(record, part, pendulum, guess);
    if (!fitted || part.end == section.end) return fitted;
    guess = fitted->x;
    span *= 2.0;
  }
}

/// The samples between two crossings of the mean.
struct HalfSwing {
  std::size_t begin = 0, end = 0;
  double peak = 0.0;
};

std::vector<HalfSwing> half_swings(const Record& record, std::size_t begin, double mean,
                                   double threshold) {
  std::vector<HalfSwing> halves;
  int side = 0;
  for (std::size_t i = begin; i < record.rate.size(); ++i) {
    const double from_mean = record.rate[i] - mean;
    const int now = from_mean > threshold ? 1 : from_mean < -threshold ? -1 : 0;
    if (now != 0 && now != side) {
      if (!halves.empty()) halves.back().end = i;
      halves.push_back({i, record.rate.size(), 0.0});
      side = now;
    }
    if (!halves.empty()) halves.back().peak = std::max(halves.back().peak, std::fabs(from_mean));
  }
  return halves;
}

/// The factor by which the variance of a mean of the residuals exceeds that of white ones.
double correlation_factor(const Eigen::VectorXd& r) {
  const double zero = r.squaredNorm();
  double factor = 1.0;
  for (Eigen::Index lag = 1; lag < r.size() / 4; ++lag) {
    const double rho = r.head(r.size() - lag).dot(r.tail(r.size() - lag)) / zero;
    if (rho < 0.05) break;
    factor += 2.0 * rho;
  }
  return factor;
}

}  // namespace

SwingFit fit_swing(const Series& yaw_rate, const Bifilar& pendulum, const std::string& name) {
  if (yaw_rate.size() < 50)
    refuse(
        "{}: {} samples of the yaw rate are too few for a swing; log half a "
        "minute of it",
        name, yaw_rate.size());
  Record record;
  for (std::size_t i = 0; i < yaw_rate.size(); ++i)
    record.t.push_back(1e-9 * static_cast<double>(yaw_rate.t_ns[i] - yaw_rate.t_ns.front()));
  record.rate = yaw_rate.value;

  // An approximate swing, from the largest rate on.
  double mean = 0.0;
  for (const double value : record.rate) mean += value / static_cast<double>(record.rate.size());
  const auto farther = [mean](double a, double b) {
    return std::fabs(a - mean) < std::fabs(b - mean);
  };
  const auto largest = std::ranges::max_element(record.rate, farther);
  const double peak = std::fabs(*largest - mean);
  const auto begin = static_cast<std::size_t>(largest - record.rate.begin());
  if (!(peak > 1e-6)) refuse("{}: the yaw rate never changes; nothing swings", name);
  const std::vector<HalfSwing> halves = half_swings(record, begin, mean, 0.1 * peak);
  std::size_t last = 0;
  std::vector<double> lengths;
  while (last + 1 < halves.size() && halves[last].peak > 0.14 * peak) {
    if (last > 0) lengths.push_back(record.t[halves[last].end] - record.t[halves[last].begin]);
    ++last;
  }
  if (lengths.size() < 8)
    refuse(
        "{}: {} swings after the largest yaw rate, at {:.1f} s of the record, are "
        "too few; at least 5 are needed, 20 are good (cut with --from, --to)",
        name, lengths.size() / 2, record.t[begin]);
  std::ranges::sort(lengths);
  const double period = 2.0 * lengths[lengths.size() / 2];
  if (period > slowest)
    refuse(
        "{}: a swing takes {:.4g} s by its times, more than the {:.0f} s of any "
        "car: are they in ms? Divide them by 1000",
        name, period, slowest);
  const double amplitude = peak * period / (2.0 * pi);
  if (amplitude > widest)
    refuse(
        "{0}: its yaw rate of up to {2:.3g} rad/s means a swing of {1:.0f} deg to each "
        "side, but the cords cross before: is that deg/s? Multiply by {3:.7f}",
        name, amplitude * 180.0 / pi, peak, pi / 180.0);
  const Section section{begin, halves[last].begin};
  const double seconds = record.t[section.end - 1] - record.t[section.begin];
  if (static_cast<double>(section.size()) * period / seconds < 8.0)
    refuse("{}: a swing of {:.2f} s has fewer than 8 samples of the yaw rate", name, period);
  for (std::size_t i = section.begin + 1; i < section.end; ++i)
    if (record.t[i] - record.t[i - 1] > 0.5 * period)
      refuse(
          "{}: no yaw rate for {:.2f} s at {:.1f} s of the record, in mid-swing; "
          "cut there with --from, --to",
          name, record.t[i] - record.t[i - 1], record.t[i]);

  Unknowns guess = Unknowns::Zero();
  guess[log_period] = std::log(period);
  guess[rate] = *largest - mean;
  guess[bias] = mean;
  guess[viscous] = 2.0 * std::log(peak / std::max(halves[last - 1].peak, 1e-3 * peak)) / seconds;
  const auto whole = fit_by_and_by(record, section, pendulum, guess);
  const double residual =
      whole ? std::sqrt(whole->residuals.squaredNorm() / static_cast<double>(section.size()))
            : peak;
  if (!whole || residual > 0.1 * peak)
    refuse(
        "{}: the yaw rate from {:.1f} s to {:.1f} s of the record is not that of "
        "a free swing by two cords; cut with --from, --to{}",
        name, record.t[section.begin], record.t[section.end - 1], exchange_hint(pendulum));

  SwingFit result;
  result.period = std::exp(whole->x[log_period]);
  result.period_sigma = whole->period_sigma * std::sqrt(correlation_factor(whole->residuals));
  // The scatter between parts of the record, which white residuals do not show.
  constexpr std::size_t parts = 4;
  if (seconds > 4.0 * parts * period) {
    std::vector<double> periods;
    const Motion motion(pendulum, whole->x);
    double theta = whole->x[angle], theta_dot = whole->x[rate];
    for (std::size_t k = 0; k < parts; ++k) {
      const Section part{section.begin + k * section.size() / parts,
                         section.begin + (k + 1) * section.size() / parts};
      Unknowns start = whole->x;
      start[angle] = theta;
      start[rate] = theta_dot;
      if (const auto fitted = fit(record, part, pendulum, start))
        periods.push_back(std::exp(fitted->x[log_period]));
      for (std::size_t i = part.begin; i < part.end; ++i)
        if (i + 1 < section.end) {
          const double dt = record.t[i + 1] - record.t[i];
          for (int step = 0; step < 4; ++step) motion.advance(0.25 * dt, theta, theta_dot);
        }
    }
    if (periods.size() == parts)
      result.period_sigma = std::max(result.period_sigma, mean_of(periods).sigma);
  }
  const double omega = 2.0 * pi / result.period;
  result.amplitude_begin = std::hypot(whole->x[angle], whole->x[rate] / omega);
  result.amplitude_end = halves[last - 1].peak / omega;
  result.damping_ratio = 0.5 * whole->x[viscous] / omega;
  result.gyro_bias = whole->x[bias];
  result.residual_rms = residual;
  result.seconds = seconds;
  result.swings = seconds / result.period;
  if (residual > 0.03 * peak)
    result.warnings.push_back(found(
        tools::kind("swing_not_free"), name,
        fmt::format("the yaw rate differs from that of a free swing by {:.1f} % of its largest "
                    "value (rms)",
                    100.0 * residual / peak)));
  return result;
}

}  // namespace odomd::tools
