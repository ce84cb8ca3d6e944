// What odom identify noise finds, of a standing car and of a drive, as numbers of the
// configuration.
#pragma once

#include <optional>
#include <string>

#include "daemon/core/config.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/identify/common/record.hpp"
#include "tools/replay/drive.hpp"

namespace odomd::tools {

/// Noise, bias and walk of the IMU at rest, and the paper's condition; the Allan deviation goes
/// into the picture `plot`, where that is named. Throws std::invalid_argument where the car does
/// not stand, or there is no IMU.
void add_standing_findings(const RecordOptions& options, const std::string& plot,
                           const std::optional<daemon::Config>& config, Findings& findings);

struct NoisyDrive {
  std::string folder;
  std::string config;  ///< empty: the folder's
  CameraUse camera = CameraUse::take;
};

/// Noise on the move and what the filter's noises ought to be. What is larger than at rest takes
/// the key from what was found there. Throws std::invalid_argument where the car does not drive.
void add_driving_findings(const NoisyDrive& noisy, const std::optional<daemon::Config>& config,
                          Findings& findings);

}  // namespace odomd::tools
