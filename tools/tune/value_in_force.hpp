// The default of a number that a configuration leaves out.
#pragma once

#include <optional>
#include <string_view>

#include "daemon/core/config.hpp"

namespace odomd::tools {

/// The number that is in force for a key: the configuration's, or the program's own. Nothing for
/// keys that are no tunable number, and for signals that are not mapped.
[[nodiscard]] std::optional<double> value_in_force(const daemon::Config& config,
                                                   std::string_view key);

}  // namespace odomd::tools
