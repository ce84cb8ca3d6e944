#include "tools/identify/inertia/bifilar.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "tools/cli/text.hpp"
#include "tools/diagnostics/kinds.hpp"
#include "tools/identify/common/agreement.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/math/median.hpp"

namespace odomd::tools {
namespace {

using std::numbers::pi;

/// Beyond these limits the record must be in other units.
constexpr double slowest = 100.0;    // period [s]
constexpr double widest = 0.5 * pi;  // amplitude [rad]

/// The part of a swing that is used: until its rate has decayed to this share.
constexpr double decayed = 0.14;

/// Scatter of the turning points about those of a free swing, relative to the period: the first
/// limit gives a warning, the second an error.
constexpr double not_free = 0.005, no_swing = 0.016;

struct Record {
  std::vector<double> t;     ///< [s], from the first sample of the log
  std::vector<double> rate;  ///< less its mean [rad/s]
};

/// Where the car turns back: the rate changes its sign.
struct TurningPoint {
  double t = 0.0;      ///< [s]
  double peak = 0.0;   ///< largest rate until the next one [rad/s]
  double slope = 0.0;  ///< of the rate [rad/s²]
};

/// The turning points after the sample `begin`, roughly; rates below `threshold` are taken as 0.
std::vector<TurningPoint> turning_points(const Record& record, std::size_t begin,
                                         double threshold) {
  std::vector<TurningPoint> points;
  std::size_t beyond = begin;
  for (std::size_t i = begin; i < record.t.size(); ++i) {
    const double size = std::fabs(record.rate[i]);
    if (size > threshold) {
      if (record.rate[i] * record.rate[beyond] < 0.0)
        points.push_back({.t = 0.5 * (record.t[beyond] + record.t[i])});
      beyond = i;
    }
    if (!points.empty()) points.back().peak = std::max(points.back().peak, size);
  }
  return points;
}

/// Refines time and slope with a straight line through the samples within `half` of the point.
void refine(const Record& record, double half, TurningPoint& point) {
  for (int round = 0; round < 2; ++round) {
    const auto begin = std::ranges::lower_bound(record.t, point.t - half) - record.t.begin();
    const auto end = std::ranges::upper_bound(record.t, point.t + half) - record.t.begin();
    using Values = Eigen::Map<const Eigen::ArrayXd>;
    const Relation line = relation_of(Values(record.rate.data() + begin, end - begin),
                                      Values(record.t.data() + begin, end - begin) - point.t);
    point.slope = line.slope;
    point.t -= line.offset / line.slope;
  }
}

/// Times [s], counted in periods of small swings: t_k = t_0 + T S_k + b / ω̇_k, with an error b of
/// the gyro's bias. Wide swings and damped swings take longer.
struct Timing {
  Measured period;
  double bias = 0.0;     ///< b [rad/s]
  double scatter = 0.0;  ///< rms of the residuals [s]
};

Timing fit_times(const std::vector<TurningPoint>& points, const Bifilar& pendulum, double period) {
  const auto n = static_cast<Eigen::Index>(points.size());
  const double inertia = inertia_per_mass(pendulum, period);
  const double damping = std::log(points.front().peak / points[points.size() - 2].peak) /
                         (pi * static_cast<double>(n));
  const double slow = 1.0 / std::sqrt(1.0 - std::min(damping * damping, 0.5));
  Eigen::MatrixX3d design(n, 3);
  Eigen::VectorXd times(n), weight(n);
  double swings = 0.0;
  for (Eigen::Index k = 0; k < n; ++k) {
    const TurningPoint& point = points[static_cast<std::size_t>(k)];
    weight[k] = std::fabs(point.slope);  // noise shifts steep zero crossings less
    design.row(k) << 1.0, swings, 1.0 / point.slope;
    times[k] = point.t;
    swings += 0.5 * slow * lengthening(pendulum, inertia, point.peak * period / (2.0 * pi));
  }
  const Eigen::MatrixX3d weighted = weight.asDiagonal() * design;
  const Eigen::Vector3d found = weighted.colPivHouseholderQr().solve(weight.cwiseProduct(times));
  const Eigen::VectorXd rest = times - design * found;
  const Eigen::Matrix3d inverse = (weighted.transpose() * weighted).inverse();
  const double variance =
      weight.cwiseProduct(rest).squaredNorm() / static_cast<double>(n - design.cols());
  return {.period = {found[1], std::sqrt(variance * inverse(1, 1))},
          .bias = -found[2],
          .scatter = std::sqrt(rest.squaredNorm() / static_cast<double>(n))};
}

/// Throws std::invalid_argument for a swing that is impossible for a car, or has too few samples.
void check_swing(const Record& record, const std::vector<TurningPoint>& points, double peak,
                 double period, const std::string& name) {
  if (period > slowest)
    refuse(
        "{}: according to its times, a swing takes {:.4g} s, and no car takes more than {:.0f} s: "
        "are they in ms? Divide them by 1000",
        name, period, slowest);
  if (const double amplitude = peak * period / (2.0 * pi); amplitude > widest)
    refuse(
        "{0}: its yaw rate of up to {2:.3g} rad/s means a swing of {1:.0f} deg to each side, but "
        "the cords cross before: is that deg/s? Multiply by {3:.7f}",
        name, amplitude * 180.0 / pi, peak, pi / 180.0);
  const auto first = std::ranges::lower_bound(record.t, points.front().t);
  const auto last = std::ranges::lower_bound(record.t, points.back().t);
  if (static_cast<double>(last - first) * period / (points.back().t - points.front().t) < 8.0)
    refuse("{}: a swing of {:.2f} s has fewer than 8 samples of the yaw rate", name, period);
  for (auto t = first; t != last; ++t)
    if (const double gap = *std::next(t) - *t; gap > 0.5 * period)
      refuse(
          "{}: no yaw rate for {:.2f} s at {:.1f} s of the record, in mid-swing; cut there with "
          "--from, --to",
          name, gap, *std::next(t));
}

}  // namespace

SwingFit fit_swing(const Series& yaw_rate, const Bifilar& pendulum, const std::string& name) {
  if (yaw_rate.size() < 50)
    refuse("{}: {} samples of the yaw rate are too few for a swing; log half a minute of it", name,
           yaw_rate.size());
  const double mean = mean_of(yaw_rate.value).value;
  Record record;
  for (std::size_t i = 0; i < yaw_rate.size(); ++i) {
    record.t.push_back(1e-9 * static_cast<double>(yaw_rate.t_ns[i] - yaw_rate.t_ns.front()));
    record.rate.push_back(yaw_rate.value[i] - mean);
  }
  const auto size = [](double rate) { return std::fabs(rate); };
  const auto largest = std::ranges::max_element(record.rate, {}, size);
  const auto begin = static_cast<std::size_t>(largest - record.rate.begin());
  const double peak = size(*largest);
  if (!(peak > 1e-6)) refuse("{}: the yaw rate never changes; nothing swings", name);

  std::vector<TurningPoint> points = turning_points(record, begin, 0.1 * peak);
  const auto end = std::ranges::find_if(
      points, [&](double rate) { return rate <= decayed * peak; }, &TurningPoint::peak);
  if (end != points.end()) points.erase(std::next(end), points.end());
  if (points.size() < 10)
    refuse(
        "{}: {} swings after the largest yaw rate, at {:.1f} s of the record, are too few; at "
        "least 5 are needed, 20 are good (cut with --from, --to)",
        name, points.size() / 2, record.t[begin]);
  std::vector<double> lengths;
  for (std::size_t k = 1; k < points.size(); ++k) lengths.push_back(points[k].t - points[k - 1].t);
  const double rough = 2.0 * median_of(std::move(lengths));
  check_swing(record, points, peak, rough, name);

  for (TurningPoint& point : points) refine(record, rough / 8.0, point);
  const Timing timing = fit_times(points, pendulum, rough);
  if (!(timing.scatter < no_swing * rough))
    refuse(
        "{}: the yaw rate from {:.1f} s to {:.1f} s of the record is not that of a free swing on "
        "two cords; cut with --from, --to{}",
        name, points.front().t, points.back().t, exchange_hint(pendulum));
  const double omega = 2.0 * pi / timing.period.value;
  SwingFit result{.period = timing.period,
                  .amplitude_begin = points.front().peak / omega,
                  .amplitude_end = points[points.size() - 2].peak / omega,
                  .gyro_bias = mean + timing.bias,
                  .swings = 0.5 * static_cast<double>(points.size() - 1)};
  if (timing.scatter > not_free * rough)
    add_warning(result.warnings, tools::kind("swing_not_free"), name,
                "the car turns back at other times than a free swing, by {:.1f} % of a period "
                "(rms)",
                100.0 * timing.scatter / rough);
  return result;
}

}  // namespace odomd::tools
