// The signals of a recorded drive as series of numbers: a log decoded by the daemon's decoder,
// without a filter; and signals on an even grid.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "can_protocol/sources/log_reader.hpp"
#include "daemon/core/config.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "estimator/common/measurement.hpp"

namespace odomd::tools {

struct Drive;  // tools/replay/drive.hpp

[[nodiscard]] inline std::string name_of(estimator::Source source) {
  return std::string(estimator::source_names[estimator::index_of(source)]);
}

/// The source's table in the configuration, or a key in it: ".latency".
[[nodiscard]] inline std::string key_of(estimator::Source source, const char* key = "") {
  return "can.signals." + name_of(source) + key;
}

/// The configured latency of a source [s].
[[nodiscard]] double configured_latency(const daemon::Config& config, estimator::Source source);

using estimator::wheel_sources;

/// Sources for the speed of the car, in the order of preference.
inline constexpr std::array speed_sources{
    estimator::Source::wheel_rear_left,  estimator::Source::wheel_rear_right,
    estimator::Source::wheel_rear,       estimator::Source::motor,
    estimator::Source::wheel_front_left, estimator::Source::wheel_front_right};

/// One quantity over time, in SI units; times strictly increasing, values finite.
struct Series {
  std::vector<std::int64_t> t_ns;  ///< sample times: the frame's stamp less the source's latency
  std::vector<double> value;

  [[nodiscard]] bool empty() const { return t_ns.empty(); }
  [[nodiscard]] std::size_t size() const { return t_ns.size(); }
  /// Mean time between samples [s]; 0 for fewer than two.
  [[nodiscard]] double cycle() const {
    if (size() < 2) return 0.0;
    return 1e-9 * static_cast<double>(t_ns.back() - t_ns.front()) / static_cast<double>(size() - 1);
  }
  void add(std::int64_t time_ns, double sample) {
    t_ns.push_back(time_ns);
    value.push_back(sample);
  }
};

struct SignalLog {
  std::string name;  ///< name of the file, or of the first of several
  std::array<Series, estimator::source_count> signals;
  std::int64_t first_ns = 0;  ///< stamp of the log's first frame
  std::int64_t last_ns = 0;
  diagnostics::Diagnostics warnings;
  /// Why a message gave no value: "message 'IMU' (yaw_rate): no frame of it is in the log; ...".
  std::array<std::string, estimator::source_count> why_empty;

  [[nodiscard]] const Series& of(estimator::Source source) const {
    return signals[estimator::index_of(source)];
  }
  [[nodiscard]] Series& of(estimator::Source source) {
    return signals[estimator::index_of(source)];
  }
  /// Time since the first frame [s].
  [[nodiscard]] double seconds(std::int64_t t_ns) const {
    return 1e-9 * static_cast<double>(t_ns - first_ns);
  }
  [[nodiscard]] bool has(estimator::Source source) const { return of(source).size() > 1; }
  /// Like of(), but requires two samples. Throws std::invalid_argument with the log and the reason,
  /// such as a missing message.
  [[nodiscard]] const Series& need(estimator::Source source) const;
};

/// A speed that is negative in reverse gear; unchanged if there is no gear.
[[nodiscard]] Series with_direction(Series speed, const Series& gear);

/// The noise of a sample, for samples evenly spaced in time; an upper bound while the car drives.
/// From third differences, which remove smooth motion, and the median of their magnitudes, so that
/// jerks and outliers do not count.
[[nodiscard]] double white_sigma(std::span<const double> values);

/// A pose of the car as a camera or a reference sees it.
struct PoseSample {
  double t = 0.0;                      ///< [s]
  double x = 0.0, y = 0.0, yaw = 0.0;  ///< of the observed point of the car; yaw is unwrapped
  double sigma_x = 0.0, sigma_y = 0.0, sigma_yaw = 0.0;
};

/// Sorted by time, keeping the first pose of each time. Times count from `origin_ns`.
[[nodiscard]] std::vector<PoseSample> in_order(std::span<const estimator::CameraPose> poses,
                                               std::int64_t origin_ns);

/// Decodes the logs ("-": standard input), merged in the order of their stamps, with the bindings
/// of a configuration; rotates accelerations by [imu] yaw as the daemon does. Leaves out frames
/// that fail their protection and samples without a time of their own, and warns of their number.
/// Throws std::invalid_argument if log, databases and configuration do not match, and for a log
/// whose times run backwards.
[[nodiscard]] SignalLog read_signals(daemon::Config config, std::span<const std::string> logs,
                                     can::Damage damage = can::Damage::left_out);

/// The signals of a drive in memory.
[[nodiscard]] SignalLog signals_of(const Drive& drive);

// Signals on an even grid, fine enough to interpolate at any time, so that they can be compared.

/// A signal at t = begin + k · step [s], linear in between and constant beyond its ends.
struct Resampled {
  double begin = 0.0;
  double step = 1e-3;
  std::vector<double> value;

  [[nodiscard]] double at(double t) const;
  [[nodiscard]] double end() const {
    return begin + step * static_cast<double>(value.empty() ? 0 : value.size() - 1);
  }
};

/// Interpolates linearly between the samples, whose times count from `origin_ns`.
[[nodiscard]] Resampled resampled(const Series& series, std::int64_t origin_ns, double begin,
                                  double end, double step = 1e-3);

/// The integral from the start, with the trapezoidal rule.
[[nodiscard]] Resampled integral(const Resampled& signal);

/// The mean over t ± half.
[[nodiscard]] Resampled mean_around(const Resampled& signal, double half);

/// The rate of change from t - half to t + half, which is the mean derivative there.
[[nodiscard]] Resampled slope_around(const Resampled& signal, double half);

/// f(t) on the grid of another signal.
template <class F>
[[nodiscard]] Resampled on_grid_of(const Resampled& signal, F f) {
  Resampled result = signal;
  for (std::size_t i = 0; i < signal.value.size(); ++i)
    result.value[i] = f(signal.begin + signal.step * static_cast<double>(i));
  return result;
}

/// f(a, b) for each value, on the grid of a.
template <class F>
[[nodiscard]] Resampled combined(const Resampled& a, const Resampled& b, F f) {
  return on_grid_of(a,
                    [&, i = std::size_t{0}](double t) mutable { return f(a.value[i++], b.at(t)); });
}

}  // namespace odomd::tools
