// The results of odom identify noise, from a standing car and a drive, as numbers of the
// configuration.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "daemon/core/config.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/identify/common/record.hpp"
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

[[nodiscard]] inline std::string sigma_key(estimator::Source source) {
  return "can.signals." + name_of(source) + ".sigma";
}

[[nodiscard]] inline bool is_configured(const std::optional<daemon::Config>& config,
                                        estimator::Source source) {
  return config && config->can.signals[static_cast<std::size_t>(source)].configured;
}

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
