// load_databases(): checks the configuration against the databases that it names.
#include <algorithm>

#include <fmt/format.h>

#include "base/nearest_name.hpp"
#include "can_protocol/decode/decoder.hpp"
#include "can_protocol/sources/open_source.hpp"
#include "daemon/core/config_sections.hpp"
#include "daemon/diagnostics/diagnostic.hpp"

namespace odomd::daemon {
namespace {

constexpr std::int64_t default_timeout_ns = 100'000'000;
constexpr std::int64_t cycles_until_overdue = 3;

/// Rejects a binding to a bus that is not a source: its values would never arrive. Skipped for
/// logs, whose buses are known only when they are read.
void check_buses(const Config& config) {
  const auto& sources = config.can.sources;
  const auto is_interface = [](const std::string& source) {
    return can::source_kind(source) == can::SourceKind::interface;
  };
  if (sources.empty() || !std::ranges::all_of(sources, is_interface)) return;
  for (const auto& binding : config.can.bindings)
    if (!binding.bus.empty() && std::ranges::find(sources, binding.bus) == sources.end())
      throw ConfigError(fmt::format("{}: signal '{}': bus '{}' is not a source{}",
                                    config.file.string(), binding.role, binding.bus,
                                    nearest_hint(binding.bus, sources)));
}

/// Leaves out warnings about messages that no role uses; `odom dbc show` lists them.
void add_content_warnings(std::span<const can::Database> databases,
                          std::span<const can::BoundMessage> messages,
                          diagnostics::Diagnostics& warnings) {
  const auto is_mapped = [&](std::uint64_t key) {
    return std::ranges::any_of(messages, [key](const can::BoundMessage& message) {
      return can::frame_key(message.id, message.format) == key;
    });
  };
  for (const can::Database& database : databases)
    for (const can::Warning& warning : database.warnings)
      if (!warning.message || is_mapped(*warning.message))
        warnings.push_back(
            found(diagnostics::kind("database_content"), {}, can::describe(database, warning)));
}

}  // namespace

std::vector<std::string> expected_buses(const Config& config) {
  std::vector<std::string> buses;
  for (const auto& binding : config.can.bindings)
    if (!binding.bus.empty() && std::ranges::find(buses, binding.bus) == buses.end())
      buses.push_back(binding.bus);
  if (buses.size() > can::max_buses)
    throw ConfigError(fmt::format("{}: [can.signals]: names {} buses; at most {} are allowed",
                                  config.file.string(), buses.size(), can::max_buses));
  return buses;
}

std::vector<can::Database> load_databases(Config& config, diagnostics::Diagnostics& warnings) {
  std::vector<can::Database> databases;
  for (const auto& file : config.can.dbc) {
    try {
      databases.push_back(can::read_dbc(file));
    } catch (const can::DbcError& error) {
      throw ConfigError(fmt::format("{} (a database for {})", error.what(), config.file.string()));
    }
  }
  check_model(config, warnings);
  check_buses(config);

  const auto buses = expected_buses(config);
  try {
    const can::Decoder decoder(databases, config.can.bindings, config.can.protections, buses);
    for (const auto& message : decoder.messages()) {
      const std::int64_t timeout_ns = message.cycle_time_ns > 0
                                          ? cycles_until_overdue * message.cycle_time_ns
                                          : default_timeout_ns;
      for (const auto channel : message.channels)
        if (auto& signal = config.can.signals[channel]; signal.timeout_ns == 0)
          signal.timeout_ns = timeout_ns;
    }
    add_content_warnings(databases, decoder.messages(), warnings);
    check_rates(config, decoder.messages(), warnings);
  } catch (const std::invalid_argument& error) {
    throw ConfigError(fmt::format("{}: {}", config.file.string(), error.what()));
  }
  return databases;
}

}  // namespace odomd::daemon
