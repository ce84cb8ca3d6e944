// Settings that were found with one configuration and are written into another.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "daemon/core/config.hpp"
#include "tools/tune/parameter.hpp"

namespace odomd::tools {

/// In which keys that a pose depends on (vehicle, signals and their protection, lever arms, filter
/// but for its model, period) the two differ, but for those that are tuned: "vehicle.mass (3, 2.9),
/// filter.window (0.25, 0.3) and 2 more". What one leaves out counts as its default. Empty where
/// they agree.
[[nodiscard]] std::string config_difference(const daemon::Config& one, const daemon::Config& other,
                                            std::span<const Parameter> tuned);

}  // namespace odomd::tools
