#include "tools/identify/noise/standstill.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "tools/math/median.hpp"

namespace odomd::tools {
namespace {

using estimator::Source;

constexpr double turning = 0.05;  // rad/s

double seconds_after(const SignalLog& log, const Series& series, std::size_t i) {
  const std::int64_t begin = log.first_ns != 0 ? log.first_ns : series.t_ns.front();
  return 1e-9 * static_cast<double>(series.t_ns[i] - begin);
}

void check_turning(const SignalLog& log, const Series& yaw_rate, double white,
                   const std::string& record) {
  const double median = median_of(yaw_rate.value);
  double squares = 0.0;
  for (const double value : yaw_rate.value) squares += (value - median) * (value - median);
  if (std::sqrt(squares / static_cast<double>(yaw_rate.size())) < 3.0 * white) return;
  for (std::size_t i = 0; i < yaw_rate.size(); ++i) {
    const double off = yaw_rate.value[i] - median;
    if (std::fabs(off) < std::max(turning, 6.0 * white)) continue;
    throw std::invalid_argument(fmt::format(
        "{}: the car moves: yaw_rate is {:.2f} rad/s off its median after {:.2f} s; log it "
        "standing, or cut with --from and --to",
        record, off, seconds_after(log, yaw_rate, i)));
  }
}

void check_curve(const AllanCurve& curve, const std::string& record) {
  const auto lowest = std::ranges::min_element(curve.points, {}, &AllanPoint::deviation);
  if (lowest == curve.points.end() || lowest->tau > 1.0) return;
  const auto highest = std::max_element(
      lowest, curve.points.end(),
      [](const AllanPoint& a, const AllanPoint& b) { return a.deviation < b.deviation; });
  if (highest->deviation - 2.0 * highest->sigma < 2.0 * lowest->deviation) return;
  throw std::invalid_argument(fmt::format(
      "{}: the car moves: means of {} over {:.2g} s differ {:.1f} times as much as those over "
      "{:.2g} s, more than a bias can explain; log it standing, or cut with --from and --to",
      record, curve.name, highest->tau, highest->deviation / lowest->deviation, lowest->tau));
}

}  // namespace

bool wheels_stand(const SignalLog& log, double limit) {
  return std::ranges::all_of(wheel_sources, [&](Source wheel) {
    return std::ranges::all_of(log.of(wheel).value,
                               [&](double speed) { return std::fabs(speed) <= limit; });
  });
}

bool has_wheels(const SignalLog& log) {
  return std::ranges::any_of(wheel_sources, [&](Source wheel) { return !log.of(wheel).empty(); });
}

void check_that_wheels_stand(const SignalLog& log, const std::string& record) {
  for (const Source wheel : wheel_sources) {
    const Series& speed = log.of(wheel);
    for (std::size_t i = 0; i < speed.size(); ++i) {
      if (std::fabs(speed.value[i]) < 0.05) continue;
      throw std::invalid_argument(fmt::format(
          "{}: the car moves: {} is {:.2f} m/s after {:.2f} s; log it standing, or cut with --from "
          "and --to",
          record, estimator::source_names[static_cast<std::size_t>(wheel)], speed.value[i],
          seconds_after(log, speed, i)));
    }
  }
}

void check_that_imu_stands(const SignalLog& log, const std::vector<AllanCurve>& curves,
                           const std::string& record) {
  const Series& yaw_rate = log.of(Source::yaw_rate);
  for (const AllanCurve& curve : curves) {
    if (curve.name == "yaw_rate") check_turning(log, yaw_rate, curve.noise.from_the_last, record);
    if (!has_wheels(log)) check_curve(curve, record);
  }
}

}  // namespace odomd::tools
