#include "tools/identify/fit/drive.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "tools/cli/text.hpp"
#include "tools/identify/fit/parameters.hpp"

namespace odomd::tools::fitting {
namespace {

using estimator::Source;

// Adds means over neighbouring samples, to limit the number of samples of a fast sensor.
void add_means(std::vector<FitSample>& samples, const Series& series, Source source, double sigma,
               std::int64_t origin_ns, double spacing) {
  const auto time = [&](std::size_t i) {
    return 1e-9 * static_cast<double>(series.t_ns[i] - origin_ns);
  };
  for (std::size_t i = 0; i < series.size();) {
    const double first = time(i);
    double t_sum = 0.0, sum = 0.0;
    int count = 0;
    for (; i < series.size() && (count == 0 || time(i) - first < spacing); ++i, ++count) {
      t_sum += time(i);
      sum += series.value[i];
    }
    samples.push_back({t_sum / count, sum / count, source, sigma / std::sqrt(count)});
  }
}

// The gyro's mean reading while the wheels are at rest for over a second, from 0.3 s after they
// stop to 0.3 s before they start. While driving, the gyro's bias may differ by `moved`.
std::optional<Measured> gyro_at_rest(const Series& speed, const Series& gyro, double slow) {
  constexpr std::int64_t margin_ns = 300'000'000, least_ns = 1'000'000'000;
  constexpr double moved = 1e-3;  // [rad/s]
  const double still = 0.02 * slow;
  std::vector<double> readings;
  for (std::size_t i = 0; i < speed.size(); ++i) {
    if (std::fabs(speed.value[i]) > still) continue;
    const std::size_t first = i;
    while (i + 1 < speed.size() && std::fabs(speed.value[i + 1]) <= still) ++i;
    if (speed.t_ns[i] - speed.t_ns[first] < least_ns) continue;
    for (std::size_t k = 0; k < gyro.size(); ++k) {
      if (gyro.t_ns[k] >= speed.t_ns[first] + margin_ns &&
          gyro.t_ns[k] <= speed.t_ns[i] - margin_ns)
        readings.push_back(gyro.value[k]);
    }
  }
  if (readings.size() < 10) return std::nullopt;
  const Measured mean = mean_of(readings);
  return Measured{mean.value, std::hypot(mean.sigma, moved)};
}

// Throws; the text names the missing message if the speed is mapped.
[[noreturn]] void refuse_without_speed(const SignalLog& log) {
  for (const Source source : speed_sources)
    if (!log.why_empty.at(estimator::index_of(source)).empty()) (void)log.need(source);
  refuse("{}: contains no wheel speed that the configuration maps", log.name);
}

}  // namespace

double slowness(const daemon::Config& config) {
  return std::clamp(std::round(std::sqrt(config.vehicle.wheelbase() / 0.26)), 1.0, 3.0);
}

double least_spacing(const daemon::Config& config) {
  return 0.02 * slowness(config) - 1e-3;
}

FitDrive prepare(std::string name, const daemon::Config& config, const SignalLog& log,
                 std::span<const estimator::CameraPose> poses, const Part& part) {
  const auto* const wheel =
      std::ranges::find_if(speed_sources, [&](Source s) { return log.has(s); });
  if (wheel == speed_sources.end()) refuse_without_speed(log);
  const Series& gyro = log.need(Source::yaw_rate);
  const Series& steering = log.need(Source::steering);
  const Series& gear = log.of(Source::direction);
  const Series speed = with_direction(log.of(*wheel), gear);

  FitDrive drive;
  drive.name = std::move(name);
  drive.poses = in_order(poses, log.first_ns);
  if (drive.poses.size() < 20)
    refuse("{}: {} of camera or reference; a fit needs a whole drive of them", drive.name,
           counted(drive.poses.size(), "pose"));
  drive.begin = drive.poses.front().t;
  drive.end = drive.poses.back().t;
  for (const Series* series : {&speed, &gyro, &steering}) {
    drive.begin = std::max(drive.begin, log.seconds(series->t_ns.front()));
    drive.end = std::min(drive.end, log.seconds(series->t_ns.back()));
  }
  drive.begin = std::max(drive.begin + 0.1, part.from);
  drive.end = std::min(drive.end - 0.1, part.to);
  if (!(drive.end - drive.begin >= least_duration))
    throw std::invalid_argument(
        drive.name + ": log and poses overlap for " +
        fixed(std::max(0.0, drive.end - drive.begin), 1) +
        " s; at least ten are needed, a minute is better. Are both on one clock?");

  const auto sigma_of = [&](Source source) {
    return config.can.signals[estimator::index_of(source)].sigma;
  };
  const auto add_source = [&](Source source, const Series& series) {
    add_means(drive.samples, series, source, sigma_of(source), log.first_ns, least_spacing(config));
  };
  for (const Source source : estimator::all_sources) {
    if (is_wheel(source))
      add_source(source, with_direction(log.of(source), gear));
    else if (is_inertial(source))
      add_source(source, log.of(source));
  }
  std::erase_if(drive.samples, [&](const FitSample& sample) {
    return sample.t < drive.begin || sample.t > drive.end;
  });
  std::ranges::sort(drive.samples, {}, &FitSample::t);

  drive.steering_cycle = steering.cycle();
  drive.steering_sigma = std::max(5e-4, sigma_of(Source::steering));
  // With margins: latencies shift the times at which the signals are read.
  const auto on_grid = [&](const Series& series) {
    return resampled(series, log.first_ns, drive.begin - 1.0, drive.end + 1.0);
  };
  // Smoothed: the fit of the dead time uses the slope of the signal.
  drive.steering = mean_around(on_grid(steering), 5e-3);
  drive.yaw_rate = on_grid(gyro);
  drive.speed = mean_around(on_grid(speed), 0.05);
  drive.rest = gyro_at_rest(speed, gyro, slowness(config));
  return drive;
}

}  // namespace odomd::tools::fitting
