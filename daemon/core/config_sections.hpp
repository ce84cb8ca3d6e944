// The sections of the configuration file whose keys depend on each other, and the checks against
// the model. Private to load_config(), load_databases() and odom import, whose columns have the
// keys of a role.
#pragma once

#include "can_protocol/decode/decoder.hpp"
#include "daemon/core/config.hpp"
#include "daemon/core/config_toml.hpp"
#include "daemon/diagnostics/diagnostic.hpp"

namespace odomd::daemon {

/// Read the keys of [can] that config_keys() lacks: read_buses() before the keys of config_keys(),
/// read_messages() after them.
void read_buses(TableReader& table, CanConfig& can);
void read_messages(TableReader& table, CanConfig& can);
[[nodiscard]] can::E2eBinding read_protection(const std::string& message, TableReader table);
void read_signal(const std::string& role, TableReader table, CanConfig& can);
/// The units that a role may have, its SI unit first.
[[nodiscard]] std::span<const can::Unit> units_of(estimator::Source role);

/// Checks roles, mounting and window against the model. Throws ConfigError.
void check_model(const Config& config, diagnostics::Diagnostics& warnings);
/// Warns of sizes that no car has, usually because they are in another unit.
void check_sizes(const Config& config, diagnostics::Diagnostics& warnings);
/// Warns when the filter's window cannot hold all samples at the messages' cycle times.
void check_rates(const Config& config, std::span<const can::BoundMessage> messages,
                 diagnostics::Diagnostics& warnings);

}  // namespace odomd::daemon
