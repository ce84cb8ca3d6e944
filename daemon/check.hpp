// `odomd --check`: what would be done, for a person to read before the car drives.
#pragma once

#include <span>
#include <string>

#include "can_protocol/dbc/dbc.hpp"
#include "daemon/core/config.hpp"

namespace odomd::daemon {

/// The summary of a configuration that has been held against its databases. Throws
/// std::invalid_argument where a source cannot be what it is called.
[[nodiscard]] std::string summary(const Config& config, std::span<const can::Database> databases,
                                  std::span<const std::string> warnings);

}  // namespace odomd::daemon
