#include "tools/doctor/sensor_checks.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "tools/math/median.hpp"

namespace odomd::tools::doctor {
namespace {

using diagnostics::Diagnostic;
using diagnostics::Diagnostics;
using diagnostics::found;
using diagnostics::kind;
using estimator::Source;

std::optional<Diagnostic> check_scatter(const Drive& drive, const SignalLog& log) {
  constexpr std::size_t enough = 40;  // poses
  const std::vector<PoseSample> poses = in_order(drive.cameras, log.first_ns);
  if (poses.size() < enough) return std::nullopt;
  const auto scatter_of = [&](double PoseSample::*value) {
    Series series;
    for (const PoseSample& pose : poses) {
      series.t_ns.push_back(std::llround(1e9 * pose.t));
      series.value.push_back(pose.*value);
    }
    return white_sigma(series);
  };
  const auto sigma_of = [&](double PoseSample::*sigma) {
    std::vector<double> values;
    for (const PoseSample& pose : poses) values.push_back(pose.*sigma);
    return median_of(std::move(values));
  };
  constexpr double degrees = 180.0 / std::numbers::pi;
  const double way = std::max(scatter_of(&PoseSample::x), scatter_of(&PoseSample::y));
  const double turn = scatter_of(&PoseSample::yaw);
  const double sigma = std::max(sigma_of(&PoseSample::sigma_x), sigma_of(&PoseSample::sigma_y));
  const double sigma_yaw = sigma_of(&PoseSample::sigma_yaw);
  constexpr double far = 4.0;
  if (way < far * sigma && turn < far * sigma_yaw) return std::nullopt;
  return found(kind("sigma_off"), "camera",
               fmt::format("its poses scatter by {:.2g} m and {:.2g} deg, their sigmas are {:.2g} "
                           "m and {:.2g} deg",
                           way, degrees * turn, sigma, degrees * sigma_yaw),
               fmt::format("the sigmas of its poses by {:.2g} (x, y) and {:.2g} (yaw)",
                           std::max(way / sigma, 1.0), std::max(turn / sigma_yaw, 1.0)));
}

/// A plateau at the largest value, again and again.
std::optional<Diagnostic> check_range(const SignalLog& log, Source source) {
  constexpr std::size_t run = 5, runs_needed = 2;
  constexpr double step = 1e-9;
  const Series& series = log.of(source);
  if (series.size() < run * run) return std::nullopt;
  double end = 0.0;
  for (const double value : series.value) end = std::max(end, std::fabs(value));
  std::size_t runs = 0, samples = 0;
  for (std::size_t i = 0, from = 0; i <= series.size(); ++i) {
    if (i < series.size() && std::fabs(series.value[i]) >= end - step) continue;
    if (i - from >= run) ++runs, samples += i - from;
    from = i + 1;
  }
  // A coarse signal repeats its other values, too.
  std::size_t others = 0, same = 1;
  for (std::size_t i = 1; i < series.size(); ++i) {
    same = series.value[i] == series.value[i - 1] ? same + 1 : 1;
    if (same == run && std::fabs(series.value[i]) < end - step) ++others;
  }
  if (runs < runs_needed || others >= runs) return std::nullopt;
  return found(kind("frozen"), name_of(source),
               fmt::format("stays at {:.3g}, the end of its range, in {} of its {} samples", end,
                           samples, series.size()));
}

}  // namespace

Diagnostics find_culprits(const Drive& drive, const SignalLog& log) {
  Diagnostics all;
  if (auto scatter = check_scatter(drive, log)) all.push_back(std::move(*scatter));
  for (const Source source : {Source::yaw_rate, Source::accel_x, Source::accel_y})
    if (auto clipped = check_range(log, source)) all.push_back(std::move(*clipped));
  return all;
}

}  // namespace odomd::tools::doctor
