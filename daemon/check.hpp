// `odomd --check`: a summary of the configuration as odomd understands it, for a person to read
// before the car drives.
#pragma once

#include <span>
#include <string>

#include "can_protocol/dbc/dbc.hpp"
#include "daemon/core/config.hpp"
#include "daemon/diagnostics/diagnostic.hpp"

namespace odomd::daemon {

/// The summary of a configuration that has been checked against its databases. Throws
/// std::invalid_argument when a source is not usable.
[[nodiscard]] std::string summary(const Config& config, std::span<const can::Database> databases,
                                  const diagnostics::Diagnostics& warnings);

}  // namespace odomd::daemon
