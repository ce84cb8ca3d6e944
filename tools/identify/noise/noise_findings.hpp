// The results of odom identify noise, from a standing car and a drive, as numbers of the
// configuration; and what they are made of.
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
  const char* walk_key;  ///< of its bias
};

inline constexpr std::array<InertialSource, 3> inertial_sources{{
    {estimator::Source::yaw_rate, "rad/s", "filter.gyro_bias_walk"},
    {estimator::Source::accel_x, "m/s2", "filter.accel_bias_walk"},
    {estimator::Source::accel_y, "m/s2", "filter.accel_bias_walk"},
}};

/// `key` for a source that a configuration maps, else none.
[[nodiscard]] inline std::string key_if_mapped(const std::optional<daemon::Config>& config,
                                               estimator::Source source, std::string key) {
  return config && is_mapped(*config, source) ? std::move(key) : "";
}

/// Noise, bias and walk of the IMU at rest, and the paper's condition; the Allan deviation is drawn
/// to `plot`, if given. Throws std::invalid_argument if the car does not stand, or there is no IMU.
void add_standing_findings(const RecordOptions& options, const std::string& plot,
                           const std::optional<daemon::Config>& config, Findings& findings);

/// The variance of the yaw rate in R of the paper's filter: "multiplied by a factor of ten to
/// compensate for additional uncertainties and vibrations". Replaces an earlier one.
void add_paper_variance(const Measured& gyro_sigma, const std::optional<daemon::Config>& config,
                        Findings& findings);

// Checks that a record is of a standing car.

/// Whether no wheel turns faster than `limit` [m/s]; also true if the log has no wheel.
[[nodiscard]] bool wheels_stand(const SignalLog& log, double limit);

/// Checks what the IMU can show: throws std::invalid_argument for a yaw rate that leaves its median
/// by 3 degrees a second where the noise of a sample is much smaller, and, without wheels, for a
/// sensor whose Allan deviation turns below a second and then doubles, which no bias does. `curves`
/// are those of the log.
void check_that_imu_stands(const SignalLog& log, const std::vector<AllanCurve>& curves,
                           const std::string& record);

/// The noise of a sensor while the car drives, from the signal alone: from third differences, which
/// remove the car's smooth motion.
struct DrivingNoise {
  Measured sigma;       ///< of a sample, all of it
  Measured white;       ///< the part that is independent for each sample
  Measured increments;  ///< the part that the next sample cancels: counts of an encoder
  double samples = 0.0;
  bool smooth = false;  ///< the motion is removed; else sigma is too large
};

/// Of stretches with samples that follow each other evenly; samples that are 0 to the last bit (a
/// wheel that stands) are left out. `samples` is 0 if there are not enough of them.
[[nodiscard]] DrivingNoise driving_noise(const Series& series);

/// Noise while driving, and the filter's noises. A value larger than at rest replaces the one found
/// there. Throws std::invalid_argument if the car does not drive.
void add_driving_findings(const DriveFiles& files, const std::optional<daemon::Config>& config,
                          Findings& findings);

// The noise of the full filter from its own innovations: the noise at which they are as large as
// the filter expects. For the wheels this is their sigma, which covers slip that no model
// describes; for gyro and accel_y, whose own noise is known, it is the process noise.

/// The innovations of one source compared with what the filter expected.
struct SourceConsistency {
  estimator::Source source = estimator::Source::yaw_rate;
  double samples = 0.0;
  /// Mean of νᵀS⁻¹ν over its dimension, each at most 16; 1 where the filter is right.
  Measured nis;
};

/// The sigma of a source's samples according to its innovations.
struct SampleNoise {
  estimator::Source source = estimator::Source::yaw_rate;
  Measured sigma;
};

struct ProcessNoise {
  std::vector<SampleNoise> wheels;        ///< [can.signals] sigma, no less than it was given
  Finding front_angle;                    ///< [filter] front_angle_error, by the gyro's innovations
  Finding side_slip;                      ///< [filter] side_slip_error, by those of accel_y
  std::vector<SourceConsistency> before;  ///< with the configuration as it was given
  std::vector<SourceConsistency> after;
};

/// Replays the drive about forty-five times with the full filter. Throws std::invalid_argument for
/// a drive that gives no pose. `report` is called for every replay.
[[nodiscard]] ProcessNoise process_noise(const Drive& drive, daemon::Config config,
                                         const ReportProgress& report = {});

}  // namespace odomd::tools
