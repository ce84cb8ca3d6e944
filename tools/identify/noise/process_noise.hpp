// The noise of the full filter from its own innovations: the noise at which they are as large as
// the filter expects. For the wheels this is their sigma, which covers slip that no model
// describes; for gyro and accel_y, whose own noise is known, it is the process noise.
#pragma once

#include <vector>

#include "tools/cli/progress.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/replay/drive.hpp"

namespace odomd::tools {

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
