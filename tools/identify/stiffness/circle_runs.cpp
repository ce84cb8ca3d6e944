#include "tools/identify/stiffness/film.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>

#include <fmt/format.h>

#include "base/seconds.hpp"
#include "tools/diagnostics/kinds.hpp"
#include "tools/identify/common/finding.hpp"

namespace odomd::tools {
namespace {

constexpr std::int64_t step_ns = 50'000'000;
constexpr std::int64_t half_window_ns = 300'000'000;
constexpr std::int64_t settling_ns = 500'000'000;
constexpr double shortest_turn = std::numbers::pi;
constexpr std::size_t samples_per_window = 4;  // minimum, of a signal in the log

struct FilmSample {
  double speed = 0.0, yaw_rate = 0.0;
  double yaw_rate_noise = 0.0;
};
using FilmSamples = std::vector<std::optional<FilmSample>>;

FilmSamples sample(const FilmMotion& motion) {
  FilmSamples samples;
  for (std::int64_t t = motion.frames.front().t_ns; t <= motion.frames.back().t_ns; t += step_ns) {
    auto& taken = samples.emplace_back();
    const auto local = local_motion(motion, t, half_window_ns);
    // Slope of a line through n points of noise σ over the length T: σ √(12 / n) / T
    if (local)
      taken = {std::abs(local->velocity), local->yaw_rate,
               local->heading_residual * std::sqrt(12.0 / static_cast<double>(local->frames)) /
                   seconds(2 * half_window_ns)};
  }
  return samples;
}

struct Extent {
  double low = 0.0, high = 0.0;

  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  [[nodiscard]] bool is_within(double noise) const {
    constexpr double part = 0.12;
    return high - low <= part * 0.5 * std::abs(high + low) + noise;
  }
};

// Successive samples with steady speed and yaw rate.
struct SteadySamples {
  std::size_t begin = 0, length = 0;
  double turn = 0.0;  // [rad]
};

SteadySamples steady_from(const FilmSamples& samples, std::size_t begin, std::size_t end) {
  SteadySamples steady{.begin = begin};
  if (!samples[begin]) return steady;
  const FilmSample& first = *samples[begin];
  Extent speed{first.speed, first.speed}, yaw_rate{first.yaw_rate, first.yaw_rate};
  for (std::size_t k = begin; k < end && samples[k]; ++k) {
    speed.add(samples[k]->speed);
    yaw_rate.add(samples[k]->yaw_rate);
    if (!speed.is_within(0.0) || !yaw_rate.is_within(8.0 * first.yaw_rate_noise)) break;
    steady.turn += seconds(step_ns) * samples[k]->yaw_rate;
    ++steady.length;
  }
  steady.turn = std::abs(steady.turn);
  return steady;
}

// Finds the steady samples that turn most, then those before and after them.
void find_steady(const FilmSamples& samples, std::size_t begin, std::size_t end,
                 std::vector<SteadySamples>& found) {
  SteadySamples best{.begin = begin};
  for (std::size_t k = begin; k < end; ++k)
    if (const SteadySamples steady = steady_from(samples, k, end); steady.turn > best.turn)
      best = steady;
  if (best.turn < shortest_turn) return;
  find_steady(samples, begin, best.begin, found);
  found.push_back(best);
  find_steady(samples, best.begin + best.length, end, found);
}

struct Stretch {
  std::int64_t begin_ns = 0, end_ns = 0;
};

// The steady stretches without their ends, where the car settles.
std::vector<Stretch> steady_stretches(const FilmMotion& motion) {
  const FilmSamples samples = sample(motion);
  std::vector<SteadySamples> found;
  find_steady(samples, 0, samples.size(), found);
  const auto time_of = [&motion](std::size_t k) {
    return motion.frames.front().t_ns + static_cast<std::int64_t>(k) * step_ns;
  };
  std::vector<Stretch> stretches;
  for (const SteadySamples& steady : found) {
    const Stretch stretch{time_of(steady.begin) + settling_ns,
                          time_of(steady.begin + steady.length - 1) - settling_ns};
    if (stretch.end_ns - stretch.begin_ns > 2 * half_window_ns) stretches.push_back(stretch);
  }
  return stretches;
}

std::vector<double> values_between(const Series& series, std::int64_t from, std::int64_t to) {
  const auto begin = std::ranges::lower_bound(series.t_ns, from) - series.t_ns.begin();
  const auto end = std::ranges::upper_bound(series.t_ns, to) - series.t_ns.begin();
  return {series.value.begin() + begin, series.value.begin() + end};
}

// Mean of a log's signal; its scatter comes from means over `windows` parts, as in the film.
Measured mean_of_signal(const Series& series, std::int64_t from, std::int64_t to,
                        std::size_t windows) {
  const std::vector<double> values = values_between(series, from, to);
  if (values.size() < samples_per_window * windows) return {};
  std::vector<double> means;
  for (std::size_t k = 0; k < windows; ++k) {
    const auto begin = values.begin() + static_cast<std::ptrdiff_t>(k * values.size() / windows);
    const auto end =
        values.begin() + static_cast<std::ptrdiff_t>((k + 1) * values.size() / windows);
    means.push_back(std::accumulate(begin, end, 0.0) / static_cast<double>(end - begin));
  }
  const Measured mean = mean_of(means);
  const double rounding = rounding_left(values, resolution_of(series.value));
  return {mean.value, std::max(std::hypot(mean.sigma, rounding), 1e-6)};
}

}  // namespace

std::vector<CircleRun> measure_circles(const std::string& film, const FilmMotion& motion,
                                       const SignalLog& log, std::int64_t offset_ns, double imu_y,
                                       diagnostics::Diagnostics& warnings) {
  std::vector<CircleRun> runs;
  for (const Stretch& stretch : steady_stretches(motion)) {
    const std::int64_t length_ns = stretch.end_ns - stretch.begin_ns;
    const auto whole = local_motion(motion, stretch.begin_ns + length_ns / 2, length_ns / 2);
    if (!whole) continue;
    CircleRun run{.film = film, .begin_ns = stretch.begin_ns, .end_ns = stretch.end_ns};
    run.turned = whole->yaw_rate * seconds(length_ns);
    run.yaw_rate = whole->yaw_rate;

    // Windows of about one radian.
    const auto windows =
        static_cast<std::size_t>(std::clamp(std::floor(std::abs(run.turned)), 3.0, 1000.0));
    const std::int64_t window_ns = length_ns / static_cast<std::int64_t>(windows);
    std::vector<double> drifts, speeds, accels;
    double heading_noise = 0.0, frames = 0.0;
    for (std::size_t k = 0; k < windows; ++k) {
      const std::int64_t middle =
          stretch.begin_ns + static_cast<std::int64_t>(k) * window_ns + window_ns / 2;
      const auto local = local_motion(motion, middle, window_ns / 2);
      if (!local) continue;
      drifts.push_back(local->drift());
      speeds.push_back(std::abs(local->velocity));
      accels.push_back(std::abs(local->velocity) * std::cos(local->drift()) * local->yaw_rate);
      heading_noise += local->heading_residual / static_cast<double>(windows);
      frames += static_cast<double>(local->frames);
    }
    if (drifts.size() < 3) continue;
    const Measured drift = mean_of(drifts);
    // The uncertainty is at least that from the noise of the headings.
    run.drift = {drift.value, std::max(drift.sigma, heading_noise / std::sqrt(frames))};
    run.speed = mean_of(speeds).value;
    run.lateral_accel = mean_of(accels).value;

    const std::int64_t from = stretch.begin_ns + offset_ns, to = stretch.end_ns + offset_ns;
    using estimator::Source;
    run.steering = mean_of_signal(log.of(Source::steering), from, to, windows);
    run.gyro = mean_of_signal(log.of(Source::yaw_rate), from, to, windows);
    run.accelerometer = mean_of_signal(log.of(Source::accel_y), from, to, windows);
    // a_y(p) = a_y - ψ̇² p_y
    if (run.accelerometer.sigma > 0.0)
      run.accelerometer.value += run.yaw_rate * run.yaw_rate * imu_y;
    if (run.steering.sigma <= 0.0) {
      add_warning(warnings, tools::kind("circle_left_out"),
                  fmt::format("{}: the circle from {:.1f} to {:.1f} s", film, seconds(run.begin_ns),
                              seconds(run.end_ns)),
                  "is left out: the log has {} samples of steering there, but {} are needed",
                  values_between(log.of(Source::steering), from, to).size(),
                  samples_per_window * windows);
      continue;
    }
    runs.push_back(run);
  }
  return runs;
}

}  // namespace odomd::tools
