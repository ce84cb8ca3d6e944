// The signals of a drive on one grid, and the noise and the bias that they show.
#include "tools/init/proposal.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include <fmt/format.h>

#include "tools/identify/common/measured.hpp"
#include "tools/math/median.hpp"

namespace odomd::tools {
namespace {

using estimator::Source;

double two_digits(double value) {
  return std::stod(fmt::format("{:.2g}", value));
}

struct Range {
  double least, most;
};

/// The range of sigmas that a filter can use: below it, the filter's model errors dominate.
Range range_of(Source role) {
  if (is_wheel(role)) return {0.02, 0.1};
  return role == Source::yaw_rate ? Range{0.005, 0.05} : Range{0.3, 2.0};
}

/// The mean reading while all wheels are at rest, without outliers. Empty if the readings scatter
/// like those of a turning car.
std::optional<double> bias_at_rest(const Series& signal, const Proposal& proposal) {
  constexpr std::size_t enough = 50;
  constexpr double max_spread = 0.02;         // rad/s: the readings of a creeping car scatter more
  constexpr double max_speed_at_rest = 0.01;  // m/s
  constexpr std::int64_t margin = 750'000'000;  // ns, before and after a reading
  std::int64_t from = 0, to = 0;                // the time in which all wheels have samples
  std::vector<std::int64_t> turning;            // times at which a wheel turns
  for (const Source role : wheel_sources) {
    if (!proposal.has(role) || proposal.of(role)->series.empty()) continue;
    const Series& wheel = proposal.of(role)->series;
    from = std::max(from, wheel.t_ns.front());
    to = to == 0 ? wheel.t_ns.back() : std::min(to, wheel.t_ns.back());
    for (std::size_t i = 0; i < wheel.size(); ++i)
      if (std::fabs(wheel.value[i]) >= max_speed_at_rest) turning.push_back(wheel.t_ns[i]);
  }
  std::ranges::sort(turning);
  std::vector<double> values;
  for (std::size_t i = 0; i < signal.size(); ++i) {
    const std::int64_t t_ns = signal.t_ns[i];
    const auto next = std::ranges::lower_bound(turning, t_ns - margin);
    if (t_ns - margin > from && t_ns + margin < to &&
        (next == turning.end() || *next > t_ns + margin))
      values.push_back(signal.value[i]);
  }
  if (values.size() < enough) return std::nullopt;
  const double middle = median_of(values);
  for (double& value : values) value -= middle;
  const double spread = median_of_magnitudes(values);
  if (spread > max_spread) return std::nullopt;
  const double bound = std::max(4.0 * spread, std::min(resolution_of(values), max_spread));
  std::erase_if(values, [bound](double value) { return std::fabs(value) > bound; });
  return middle + mean_of(values).value;
}

}  // namespace

std::vector<Resampled> on_one_grid(const std::vector<const Series*>& signals) {
  constexpr double step = 0.05, half = 0.25;  // s
  if (signals.empty() || std::ranges::any_of(signals, &Series::empty)) return {};
  std::int64_t from = signals[0]->t_ns.front(), to = signals[0]->t_ns.back();
  for (const Series* signal : signals) {
    from = std::max(from, signal->t_ns.front());
    to = std::min(to, signal->t_ns.back());
  }
  const double length = 1e-9 * static_cast<double>(to - from);
  if (length < 2.0 * half) return {};
  std::vector<Resampled> all;
  for (const Series* signal : signals)
    all.push_back(mean_around(resampled(*signal, from, 0.0, length, step), half));
  return all;
}

DriveCourse::DriveCourse(const Proposal& proposal) {
  std::vector<const Series*> found;
  std::vector<std::size_t> roles;
  for (std::size_t i = 0; i < proposal.roles.size(); ++i)
    if (const auto& choice = proposal.roles.at(i);
        choice && choice->series.size() > 1 &&
        choice->candidate.role != estimator::Source::direction) {
      found.push_back(&choice->series);
      roles.push_back(i);
    }
  const std::vector<Resampled> courses = on_one_grid(found);
  if (courses.empty()) return;
  Resampled mean{courses[0].begin, courses[0].step, std::vector(courses[0].value.size(), 0.0)};
  double wheels = 0.0;
  for (std::size_t k = 0; k < roles.size(); ++k)
    if (estimator::is_wheel(static_cast<estimator::Source>(roles[k]))) {
      mean = combined(mean, courses[k], std::plus{});
      ++wheels;
    }
  double fastest = 0.0;
  for (double& value : mean.value) {
    value /= std::max(wheels, 1.0);
    fastest = std::max(fastest, std::fabs(value));
  }
  // At lower speeds the noise of a_y / v is too large.
  const double least_speed = std::clamp(0.25 * fastest, 0.2, 3.0);
  const auto moving = [&](const Resampled& signal) {
    std::vector<double> values;
    for (std::size_t i = 0; i < mean.value.size(); ++i)
      if (std::fabs(mean.value[i]) > least_speed) values.push_back(signal.value[i]);
    return Eigen::ArrayXd(Eigen::Map<const Eigen::ArrayXd>(values.data(), std::ssize(values)));
  };
  for (std::size_t k = 0; k < roles.size(); ++k) signals.at(roles[k]) = moving(courses[k]);
  constexpr double around = 0.1;  // s
  speed = moving(mean);
  acceleration = moving(slope_around(mean, around));
}

void set_noise(Proposal& proposal) {
  for (const Source role : estimator::all_sources) {
    auto& choice = proposal.of(role);
    if (!(is_inertial(role) || is_wheel(role)) || !choice || choice->series.size() < 20) continue;
    const double noise =
        std::max(white_sigma(choice->series.value), resolution_of(choice->series.value));
    const auto [least, most] = range_of(role);
    choice->sigma = two_digits(std::clamp(noise, least, most));
    choice->reasons.emplace_back("sigma from the log");
  }
  auto& gyro = proposal.of(Source::yaw_rate);
  if (!gyro) return;
  constexpr double min_bias = 0.001, max_plausible_bias = 0.035;  // rad/s
  if (const auto bias = bias_at_rest(gyro->series, proposal); bias && std::fabs(*bias) > min_bias) {
    gyro->offset = -std::round(1e5 * *bias) / 1e5;
    gyro->reasons.emplace_back("offset: its bias at rest");
    if (std::fabs(*bias) > max_plausible_bias)
      gyro->warnings.push_back(fmt::format(
          "a bias of {:.2g} rad/s is large: was the car at rest whenever the wheels read 0?",
          *bias));
  }
}

}  // namespace odomd::tools
