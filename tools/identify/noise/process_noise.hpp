// The noise of the full filter by its own innovations: so large that they are as large as the
// filter expects them. Of the wheels that is their sigma, for slip that no model tells; of gyro and
// accel_y, whose own noise is known, the noise of the process.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tools/cli/progress.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/replay/drive.hpp"

namespace odomd::tools {

/// How one source's samples lay to what the filter expected of them.
struct SourceConsistency {
  estimator::Source source = estimator::Source::yaw_rate;
  double samples = 0.0;
  Measured
      nis;  ///< mean of νᵀS⁻¹ν over its dimension, each at most 16; 1 where the filter is right
};

/// The sigma of a source's samples that its innovations ask for.
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
  int replays = 0;
};

/// Replays the drive some forty-five times by the full filter. Throws std::invalid_argument for a
/// drive that gives no pose. `tell` hears of every replay.
[[nodiscard]] ProcessNoise process_noise(const Drive& drive, daemon::Config config,
                                         const TellProgress& tell = {});

}  // namespace odomd::tools
