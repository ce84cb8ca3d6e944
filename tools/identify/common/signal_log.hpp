// The signals of a recorded drive as series of numbers: a log decoded by the daemon's decoder,
// without a filter.
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

/// Its table in the configuration, or a key there: ".latency".
[[nodiscard]] inline std::string key_of(estimator::Source source, const char* key = "") {
  return "can.signals." + name_of(source) + key;
}

[[nodiscard]] inline bool is_mapped(const daemon::Config& config, estimator::Source source) {
  return config.can.signals[estimator::index_of(source)].configured;
}

/// The latency of a source by the configuration [s].
[[nodiscard]] double configured_latency(const daemon::Config& config, estimator::Source source);

/// The signal that a source is mapped to; null: none.
[[nodiscard]] const can::SignalBinding* binding_of(const daemon::Config& config,
                                                   estimator::Source source);

inline constexpr std::array wheel_sources{
    estimator::Source::wheel_front_left, estimator::Source::wheel_front_right,
    estimator::Source::wheel_rear_left,  estimator::Source::wheel_rear_right,
    estimator::Source::wheel_rear,       estimator::Source::motor};

/// In the order in which one of them stands for the speed of the car.
inline constexpr std::array speed_sources{
    estimator::Source::wheel_rear_left,  estimator::Source::wheel_rear_right,
    estimator::Source::wheel_rear,       estimator::Source::motor,
    estimator::Source::wheel_front_left, estimator::Source::wheel_front_right};

/// One quantity over time, in SI units; times strictly increasing, values finite.
struct Series {
  std::vector<std::int64_t> t_ns;  ///< sample times: the frame's stamp less its latency
  std::vector<double> value;

  [[nodiscard]] bool empty() const { return t_ns.empty(); }
  [[nodiscard]] std::size_t size() const { return t_ns.size(); }
  void add(std::int64_t time_ns, double sample) {
    t_ns.push_back(time_ns);
    value.push_back(sample);
  }
};

struct SignalLog {
  std::string name;  ///< of the file, or of the first of several
  std::array<Series, estimator::source_count> signals;
  std::int64_t first_ns = 0;  ///< of all frames
  std::int64_t last_ns = 0;
  diagnostics::Diagnostics warnings;
  /// "message 'IMU' (yaw_rate): no frame of it is in the log; ...", where a message gave no value.
  std::array<std::string, estimator::source_count> why_empty;

  [[nodiscard]] const Series& of(estimator::Source source) const {
    return signals[estimator::index_of(source)];
  }
  [[nodiscard]] Series& of(estimator::Source source) {
    return signals[estimator::index_of(source)];
  }
  /// After the first frame [s].
  [[nodiscard]] double seconds(std::int64_t t_ns) const {
    return 1e-9 * static_cast<double>(t_ns - first_ns);
  }
  [[nodiscard]] bool has(estimator::Source source) const { return of(source).size() > 1; }
  /// Like of(), with at least two samples. Throws std::invalid_argument that names the log and the
  /// reason: the missing message.
  [[nodiscard]] const Series& need(estimator::Source source) const;
};

/// A speed that is negative in reverse gear. Without a gear it is as measured.
[[nodiscard]] Series with_direction(Series speed, const Series& gear);

/// The noise of a sample: an upper bound while the car drives. From third differences, which remove
/// smooth motion, and from the median of their size, so that jerks and outliers do not count.
[[nodiscard]] double white_sigma(const Series& series);

/// Where a camera or a reference sees the car.
struct PoseSample {
  double t = 0.0;                      ///< [s]
  double x = 0.0, y = 0.0, yaw = 0.0;  ///< of the camera's point; yaw unwrapped
  double sigma_x = 0.0, sigma_y = 0.0, sigma_yaw = 0.0;
};

/// In the order of time, the first of each time. Times count from `origin_ns`.
[[nodiscard]] std::vector<PoseSample> in_order(std::span<const estimator::CameraPose> poses,
                                               std::int64_t origin_ns);

/// Decodes the logs ("-": standard input), merged in the order of their stamps, by the bindings of
/// a configuration; accelerations are turned by [imu] yaw as the daemon does. Frames that fail
/// their protection and samples without a time of their own are left out, which a warning counts.
/// Throws std::invalid_argument if log, databases and configuration do not fit together, and for a
/// log whose times run backwards.
[[nodiscard]] SignalLog read_signals(daemon::Config config, std::span<const std::string> logs,
                                     can::Damage damage = can::Damage::left_out);

/// The same of a drive in memory.
[[nodiscard]] SignalLog signals_of(const Drive& drive);

}  // namespace odomd::tools
