#include "tools/identify/noise/standing_noise.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/chart/chart.hpp"
#include "tools/chart/picture.hpp"
#include "tools/identify/common/refuse.hpp"

namespace odomd::tools {

std::vector<AllanPoint> allan_deviation(const Series& series, const std::string& name) {
  const std::size_t n = series.size();
  std::vector<AllanPoint> curve;
  if (n < 20) return curve;
  const double span = 1e-9 * static_cast<double>(series.t_ns.back() - series.t_ns.front());
  const double dt = span / static_cast<double>(n - 1);
  std::int64_t longest = 0;
  for (std::size_t i = 1; i < n; ++i)
    longest = std::max(longest, series.t_ns[i] - series.t_ns[i - 1]);
  if (1e-9 * static_cast<double>(longest) > 0.1 * span)
    refuse("{}: no sample for {:.1f} s; cut the record there with --from, --to", name,
           1e-9 * static_cast<double>(longest));
  // Sums of the deviations from the first sample: their differences give means over m samples.
  std::vector<double> sum(n + 1, 0.0);
  for (std::size_t i = 0; i < n; ++i) sum[i + 1] = sum[i] + series.value[i] - series.value.front();
  std::size_t last = 0;
  for (double wanted = 1.0; wanted <= static_cast<double>(n) / 5.0;
       wanted *= std::pow(10.0, 1.0 / 6.0)) {
    const auto m = static_cast<std::size_t>(std::lround(wanted));
    if (m == last) continue;
    last = m;
    double squares = 0.0;
    const std::size_t count = n - 2 * m + 1;
    for (std::size_t i = 0; i < count; ++i) {
      const double difference = sum[i + 2 * m] - 2.0 * sum[i + m] + sum[i];
      squares += difference * difference;
    }
    const auto length = static_cast<double>(m);
    const double deviation =
        std::sqrt(squares / (2.0 * static_cast<double>(count) * length * length));
    const double independent = static_cast<double>(n) / length - 1.0;
    curve.push_back({length * dt, deviation, deviation / std::sqrt(2.0 * independent)});
  }
  return curve;
}

BiasInstability bias_instability(const std::vector<AllanPoint>& curve) {
  BiasInstability instability;
  const auto lowest = std::ranges::min_element(curve, {}, &AllanPoint::deviation);
  if (lowest == curve.end()) return instability;
  constexpr double flicker = 0.664;  // sqrt(2 ln 2 / pi)
  instability.value = {lowest->deviation / flicker, lowest->sigma / flicker};
  instability.tau = lowest->tau;
  // The curve has risen by more than its uncertainty.
  instability.reached = std::any_of(lowest, curve.end(), [&](const AllanPoint& later) {
    return later.deviation - lowest->deviation > 2.0 * std::hypot(later.sigma, lowest->sigma);
  });
  return instability;
}

std::vector<chart::Drawing> draw(const std::vector<AllanCurve>& curves) {
  std::vector<chart::Drawing> drawings;
  for (const AllanCurve& curve : curves) {
    chart::Chart picture;
    picture.title = "Allan deviation of " + curve.name;
    picture.x = {.label = "averaged over [s]", .scaling = chart::Scaling::logarithmic};
    picture.y = {.label = "[" + curve.unit + "]", .scaling = chart::Scaling::logarithmic};
    picture.height = 300.0;
    chart::Band band{.label = "± σ", .colour = chart::colours[0], .points = {}};
    chart::Series measured{.label = "measured", .colour = chart::colours[0]};
    chart::Series white{.label = "white noise",
                        .note = fmt::format("{:.3g} {}/√Hz", curve.noise.density.value, curve.unit),
                        .colour = chart::colours[1]};
    chart::Series walk{.label = "random walk", .note = "", .colour = chart::colours[2]};
    for (const AllanPoint& point : curve.points) {
      measured.points.push_back({point.tau, point.deviation});
      band.points.push_back(
          {point.tau, point.deviation - point.sigma, point.deviation + point.sigma});
      // σ²(τ) = N²/τ + K² τ/3
      white.points.push_back({point.tau, curve.noise.density.value / std::sqrt(point.tau)});
      if (!curve.noise.walk) continue;
      const double risen = curve.noise.walk->value * std::sqrt(point.tau / 3.0);
      if (risen > 0.1 * point.deviation) walk.points.push_back({point.tau, risen});
    }
    picture.bands = {band};
    picture.series = {white};
    if (curve.noise.walk) {
      walk.note = fmt::format("{:.2g} {}/√s", curve.noise.walk->value, curve.unit);
      picture.series.push_back(walk);
    }
    picture.series.push_back(measured);
    drawings.push_back(chart::draw(picture));
  }
  return drawings;
}

}  // namespace odomd::tools
