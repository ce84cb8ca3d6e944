// The results of odom identify noise, from a car at rest and from a drive, as numbers of the
// configuration, and the data behind them.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "daemon/core/config.hpp"
#include "tools/cli/progress.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/identify/common/record.hpp"
#include "tools/identify/noise/standing_noise.hpp"
#include "tools/replay/drive.hpp"

namespace odomd::tools {

struct InertialSource {
  estimator::Source source;
  const char* unit;
  const char* walk_key;  ///< key of the walk of the sensor's bias
};

inline constexpr std::array<InertialSource, 3> inertial_sources{{
    {estimator::Source::yaw_rate, "rad/s", "filter.gyro_bias_walk"},
    {estimator::Source::accel_x, "m/s2", "filter.accel_bias_walk"},
    {estimator::Source::accel_y, "m/s2", "filter.accel_bias_walk"},
}};

/// `key` if the configuration maps the source; otherwise none.
[[nodiscard]] inline std::string key_if_mapped(const std::optional<daemon::Config>& config,
                                               estimator::Source source, std::string key) {
  return config && is_mapped(*config, source) ? std::move(key) : "";
}

/// Noise, bias and walk of the IMU at rest, and the paper's condition; draws the Allan deviation to
/// `plot`, if given. Throws std::invalid_argument if the car moves, or if there is no IMU.
void add_standing_findings(const RecordOptions& options, const std::string& plot,
                           const std::optional<daemon::Config>& config, Findings& findings);

/// The variance of the yaw rate in R of the paper's filter: "multiplied by a factor of ten to
/// compensate for additional uncertainties and vibrations". Replaces an earlier finding.
void add_paper_variance(const Measured& gyro_sigma, const std::optional<daemon::Config>& config,
                        Findings& findings);

// Checks that a record is of a car at rest.

/// Whether no wheel turns faster than `limit` [m/s]; also true if the log has no wheel.
[[nodiscard]] bool wheels_stand(const SignalLog& log, double limit);

/// Throws std::invalid_argument if the yaw rate leaves its median by 3 degrees a second although
/// the noise of a sample is much smaller; and, if there are no wheels, for a sensor whose Allan
/// deviation has its minimum below a second and then doubles, which no bias causes. `curves` are
/// those of the log.
void check_that_imu_stands(const SignalLog& log, const std::vector<AllanCurve>& curves,
                           const std::string& record);

/// The noise of a sensor while the car drives, from its signal alone: from third differences, which
/// remove the car's smooth motion.
struct DrivingNoise {
  Measured sigma;       ///< whole noise of a sample
  Measured white;       ///< the part that is independent for each sample
  Measured increments;  ///< the part that the next sample cancels: counts of an encoder
  double samples = 0.0;
  bool smooth = false;  ///< the motion is removed; otherwise sigma is too large
};

/// Uses consecutive samples at an even rate, without those that are exactly 0 (a wheel at rest).
/// `samples` is 0 if there are not enough of them.
[[nodiscard]] DrivingNoise driving_noise(const Series& series);

/// Noise while driving, and the filter's noise settings. A value larger than the one at rest
/// replaces it. Throws std::invalid_argument if the car does not drive.
void add_driving_findings(const DriveFiles& files, const std::optional<daemon::Config>& config,
                          Findings& findings);

// The noise of the full filter from its own innovations: the noise for which they are as large as
// the filter expects. For the wheels this is their sigma, which includes slip that no model
// describes; for gyro and accel_y, whose own noise is known, it is the process noise.

/// A source's innovations compared with the filter's expectation.
struct SourceConsistency {
  estimator::Source source = estimator::Source::yaw_rate;
  double samples = 0.0;
  /// Mean of νᵀS⁻¹ν / its dimension, each at most 16; 1 if the filter is right.
  Measured nis;
};

/// The sigma of a source's samples according to its innovations.
struct SampleNoise {
  estimator::Source source = estimator::Source::yaw_rate;
  Measured sigma;
};

struct ProcessNoise {
  std::vector<SampleNoise> wheels;  ///< [can.signals] sigma, at least the configured one
  Finding front_angle;              ///< [filter] front_angle_error, from innovations of yaw_rate
  Finding side_slip;                ///< [filter] side_slip_error, from those of accel_y
  std::vector<SourceConsistency> before;  ///< with the configuration as given
  std::vector<SourceConsistency> after;
};

/// Replays the drive about 45 times with the full filter. Throws std::invalid_argument for a drive
/// that gives no pose. `report` is called for every replay.
[[nodiscard]] ProcessNoise process_noise(const Drive& drive, daemon::Config config,
                                         const ReportProgress& report = {});

}  // namespace odomd::tools
