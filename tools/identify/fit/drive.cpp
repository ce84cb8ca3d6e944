#include "tools/identify/fit/drive.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "tools/cli/text.hpp"
#include "tools/identify/fit/parameters.hpp"

namespace odomd::tools::fitting {
namespace {

using estimator::Source;

constexpr std::array speeds{Source::wheel_rear_left,  Source::wheel_rear_right,
                            Source::wheel_rear,       Source::motor,
                            Source::wheel_front_left, Source::wheel_front_right};

// Means over neighbours, to limit the number of samples of a fast sensor.
void add(std::vector<Sample>& samples, const Series& series, Source source, double sigma,
         std::int64_t origin_ns, const Series& direction, double spacing) {
  double t_sum = 0.0, sum = 0.0, first = 0.0;
  int count = 0;
  std::size_t gear = 0;
  const auto close = [&] {
    if (count > 0)
      samples.push_back({t_sum / count, sum / count, source, sigma / std::sqrt(count)});
    t_sum = sum = 0.0;
    count = 0;
  };
  const bool is_speed = std::ranges::find(speeds, source) != speeds.end();
  for (std::size_t i = 0; i < series.size(); ++i) {
    const double t = 1e-9 * static_cast<double>(series.t_ns[i] - origin_ns);
    while (gear + 1 < direction.size() && direction.t_ns[gear + 1] <= series.t_ns[i]) ++gear;
    const bool backwards = is_speed && !direction.empty() && direction.value[gear] < 0.0;
    if (count > 0 && t - first >= spacing) close();
    if (count == 0) first = t;
    t_sum += t;
    sum += backwards ? -std::fabs(series.value[i]) : series.value[i];
    ++count;
  }
  close();
}

// The gyro's mean where the wheels stand for a second and more, 0.3 s after they stop and before
// they go; its bias may have moved since.
std::optional<Measured> gyro_at_rest(const Series& speed, const Series& gyro, double slow) {
  constexpr std::int64_t margin_ns = 300'000'000, least_ns = 1'000'000'000;
  constexpr double moved = 1e-3;  // [rad/s]
  const double still = 0.02 * slow;
  double sum = 0.0, squares = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < speed.size(); ++i) {
    if (std::fabs(speed.value[i]) > still) continue;
    const std::size_t first = i;
    while (i + 1 < speed.size() && std::fabs(speed.value[i + 1]) <= still) ++i;
    if (speed.t_ns[i] - speed.t_ns[first] < least_ns) continue;
    for (std::size_t k = 0; k < gyro.size(); ++k) {
      if (gyro.t_ns[k] < speed.t_ns[first] + margin_ns || gyro.t_ns[k] > speed.t_ns[i] - margin_ns)
        continue;
      sum += gyro.value[k];
      squares += gyro.value[k] * gyro.value[k];
      ++count;
    }
  }
  if (count < 10) return std::nullopt;
  const double mean = sum / count;
  const double scatter = std::max(0.0, squares / count - mean * mean);
  return Measured{mean, std::sqrt(scatter / count + moved * moved)};
}

// Names the missing message, if one is bound.
[[noreturn]] void refuse_without_speed(const SignalLog& log) {
  for (const Source source : speeds)
    if (!log.why_empty.at(static_cast<std::size_t>(source)).empty()) (void)log.need(source);
  throw std::invalid_argument(log.name + ": contains no wheel speed that the configuration maps");
}

}  // namespace

double slowness(const daemon::Config& config) {
  return std::clamp(std::round(std::sqrt(config.vehicle.wheelbase() / 0.26)), 1.0, 3.0);
}

double least_spacing(const daemon::Config& config) {
  return 0.02 * slowness(config) - 1e-3;
}

Drive prepare(std::string name, const daemon::Config& config, const SignalLog& log,
              std::span<const estimator::CameraPose> poses, const Part& part) {
  Drive drive;
  drive.name = std::move(name);
  const std::int64_t origin = log.first_ns;
  const auto seconds = [origin](std::int64_t t_ns) {
    return 1e-9 * static_cast<double>(t_ns - origin);
  };

  const auto* const speed =
      std::ranges::find_if(speeds, [&](Source s) { return log.of(s).size() > 1; });
  if (speed == speeds.end()) refuse_without_speed(log);
  (void)log.need(Source::yaw_rate);
  (void)log.need(Source::steering);

  std::vector<const estimator::CameraPose*> seen;
  for (const estimator::CameraPose& pose : poses) seen.push_back(&pose);
  std::ranges::sort(seen, {}, &estimator::CameraPose::capture_ns);
  double yaw = seen.empty() ? 0.0 : seen.front()->yaw;
  for (const estimator::CameraPose* pose : seen) {
    const double t = seconds(pose->capture_ns);
    if (!drive.poses.empty() && t <= drive.poses.back().t) continue;
    yaw += std::remainder(pose->yaw - yaw, 2.0 * std::numbers::pi);
    drive.poses.push_back(
        {t, pose->x, pose->y, yaw, pose->sigma_x, pose->sigma_y, pose->sigma_yaw});
  }
  if (drive.poses.size() < 20)
    throw std::invalid_argument(drive.name + ": " + counted(drive.poses.size(), "pose") +
                                " of camera or reference; a fit needs a whole drive of them");

  drive.begin = std::max({drive.poses.front().t, seconds(log.of(*speed).t_ns.front()),
                          seconds(log.of(Source::yaw_rate).t_ns.front()),
                          seconds(log.of(Source::steering).t_ns.front())}) +
                0.1;
  drive.end = std::min({drive.poses.back().t, seconds(log.of(*speed).t_ns.back()),
                        seconds(log.of(Source::yaw_rate).t_ns.back()),
                        seconds(log.of(Source::steering).t_ns.back())}) -
              0.1;
  drive.begin = std::max(drive.begin, part.from);
  drive.end = std::min(drive.end, part.to);
  if (!(drive.end - drive.begin >= least_duration))
    throw std::invalid_argument(
        drive.name + ": log and poses overlap for " +
        fixed(std::max(0.0, drive.end - drive.begin), 1) +
        " s; at least ten are needed, a minute is better. Are both on one clock?");

  for (std::size_t k = 0; k < estimator::source_count; ++k) {
    const auto source = static_cast<Source>(k);
    if (source == Source::steering || source == Source::direction || source == Source::camera ||
        log.signals[k].empty())
      continue;
    add(drive.samples, log.signals[k], source, config.can.signals[k].sigma, origin,
        log.of(Source::direction), least_spacing(config));
  }
  std::erase_if(drive.samples, [&](const Sample& sample) {
    return sample.t < drive.begin || sample.t > drive.end;
  });
  std::ranges::sort(drive.samples, {}, &Sample::t);

  const std::vector<std::int64_t>& steered = log.of(Source::steering).t_ns;
  drive.steering_cycle = 1e-9 * static_cast<double>(steered.back() - steered.front()) /
                         static_cast<double>(steered.size() - 1);
  drive.steering_sigma =
      std::max(5e-4, config.can.signals[static_cast<std::size_t>(Source::steering)].sigma);
  // Margins, as latencies shift the times looked up.
  const double from = drive.begin - 1.0, to = drive.end + 1.0;
  // Smooth, as the dead time is fitted by the slope.
  drive.steering =
      mean_around(integral(resampled(log.of(Source::steering), origin, from, to)), 5e-3);
  drive.yaw_rate = resampled(log.of(Source::yaw_rate), origin, from, to);
  Series moving = log.of(*speed);
  if (const Series& gear = log.of(Source::direction); !gear.empty()) {
    std::size_t g = 0;
    for (std::size_t i = 0; i < moving.size(); ++i) {
      while (g + 1 < gear.size() && gear.t_ns[g + 1] <= moving.t_ns[i]) ++g;
      if (gear.value[g] < 0.0) moving.value[i] = -std::fabs(moving.value[i]);
    }
  }
  drive.rest = gyro_at_rest(moving, log.of(Source::yaw_rate), slowness(config));
  const Resampled raw = resampled(moving, origin, from, to);
  drive.speed = mean_around(integral(raw), 0.05);
  return drive;
}

}  // namespace odomd::tools::fitting
