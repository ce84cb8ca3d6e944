// The sections of the configuration file, each read by a function of its own, and what the model
// asks of them. Private to load_config() and load_databases().
#pragma once

#include "can_protocol/decode/decoder.hpp"
#include "daemon/core/config.hpp"
#include "daemon/core/config_toml.hpp"

namespace odomd::daemon {

[[nodiscard]] CanConfig read_can(TableReader table);
[[nodiscard]] can::E2eBinding read_protection(const std::string& message, TableReader table);
void read_signal(const std::string& role, TableReader table, CanConfig& can);

/// Roles, mounting and window against the model. Throws ConfigError.
void check_model(const Config& config, std::vector<std::string>& warnings);
/// What no car has, as of numbers in another unit.
void doubt_sizes(const Config& config, std::vector<std::string>& warnings);
/// Whether the filter's window holds all that comes at the messages' cycle times.
void check_rates(const Config& config, std::span<const can::BoundMessage> messages,
                 std::vector<std::string>& warnings);

}  // namespace odomd::daemon
