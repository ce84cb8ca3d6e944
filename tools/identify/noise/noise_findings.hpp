// The results of odom identify noise, from a standing car and a drive, as numbers of the
// configuration.
#pragma once

#include <optional>
#include <string>

#include "daemon/core/config.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/identify/common/record.hpp"
#include "tools/replay/drive.hpp"

namespace odomd::tools {

/// Noise, bias and walk of the IMU at rest, and the paper's condition; the Allan deviation is drawn
/// to `plot`, if given. Throws std::invalid_argument if the car does not stand, or there is no IMU.
void add_standing_findings(const RecordOptions& options, const std::string& plot,
                           const std::optional<daemon::Config>& config, Findings& findings);

struct NoisyDrive {
  std::string folder;
  std::string config;  ///< empty: the folder's
  CameraUse camera = CameraUse::take;
};

/// Noise while driving, and the filter's noises. A value larger than at rest replaces the one found
/// there. Throws std::invalid_argument if the car does not drive.
void add_driving_findings(const NoisyDrive& noisy, const std::optional<daemon::Config>& config,
                          Findings& findings);

}  // namespace odomd::tools
