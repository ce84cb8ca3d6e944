// odom init: creates a valid car.toml from databases and a drive, and shows it as a table or JSON.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "can_protocol/decode/signal_binding.hpp"
#include "can_protocol/sources/log_reader.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/init/proposal.hpp"

namespace odomd::tools {

struct Draft {
  Proposal proposal;
  Car car;
  std::vector<can::E2eBinding> protections;
  std::vector<std::string> databases;  ///< as the configuration names them
  std::vector<std::string> sources;    ///< interfaces
  std::string made_from;               ///< "car.dbc and drive.log"
};

/// A number of [vehicle] and its origin.
struct VehicleValue {
  std::string key;
  double value = 0.0;
  std::string origin;
  bool sure = true;
};

/// The keys of [vehicle]. Unknown numbers get values typical of the class of cars, which are marked
/// as not sure.
[[nodiscard]] std::vector<VehicleValue> vehicle_values(const Draft& draft);

[[nodiscard]] std::string as_toml(const Draft& draft);
[[nodiscard]] std::string as_text(const Draft& draft);
[[nodiscard]] nlohmann::ordered_json as_json(const Draft& draft);

enum class Overwrite : std::uint8_t { refuse, replace };

struct InitOptions {
  std::vector<std::string> databases;          ///< none: the VESC's, or odomd.dbc
  std::optional<int> vesc;                     ///< its ID; a database is made for it
  std::vector<std::string> can;                ///< logs, or one interface
  double listen_s = 20.0;                      ///< how long to listen to an interface [s]
  can::Damage damage = can::Damage::left_out;  ///< how to treat damage of the logs
  std::filesystem::path out = "car.toml";
  Overwrite overwrite = Overwrite::refuse;
  CarTexts car;
};

struct InitResult {
  Draft draft;
  std::vector<can::Database> databases;  ///< the draft points into them
  diagnostics::Diagnostics warnings;     ///< about the logs, and those of odomd --check
  std::string wrote_database;            ///< "odomd.dbc", next to the configuration; empty: none
};

/// Writes options.out after it has loaded as a configuration with its databases. Otherwise writes
/// nothing and throws std::invalid_argument, which names the file, the line or the missing options.
[[nodiscard]] InitResult init(const InitOptions& options);

}  // namespace odomd::tools
