// The names of sensors in the findings of odom identify noise, and their keys in a configuration.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "tools/identify/common/signal_log.hpp"

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

}  // namespace odomd::tools
