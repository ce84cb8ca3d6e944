// The sections of the configuration file, each read by a function of its own. Private to
// load_config().
#pragma once

#include "daemon/config.hpp"
#include "daemon/config_toml.hpp"

namespace odomd::daemon {

[[nodiscard]] CanConfig read_can(TableReader table);
[[nodiscard]] can::E2eBinding read_protection(const std::string& message, TableReader table);
void read_signal(const std::string& role, TableReader table, CanConfig& can);

}  // namespace odomd::daemon
