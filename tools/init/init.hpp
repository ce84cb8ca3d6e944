// odom init: from databases and a drive to a car.toml that loads.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

#include "can_protocol/sources/log_reader.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/init/car.hpp"
#include "tools/init/motor_controller.hpp"
#include "tools/init/writer.hpp"

namespace odomd::tools {

enum class Overwrite : std::uint8_t { refuse, replace };

struct InitOptions {
  std::vector<std::string> databases;  ///< none: a controller's, or odomd.dbc if the bus is ours
  ControllerTexts controllers;
  std::vector<std::string> can;                ///< logs, or one interface
  double listen_s = 20.0;                      ///< to an interface
  can::Damage damage = can::Damage::left_out;  ///< of the logs
  std::filesystem::path out = "car.toml";
  Overwrite overwrite = Overwrite::refuse;
  CarTexts car;
};

/// Who answers; without a dialogue what is missing is refused.
struct Dialogue {
  std::istream& in;
  std::ostream& out;
};

struct InitResult {
  Draft draft;
  std::vector<can::Database> databases;  ///< the draft points into them
  diagnostics::Diagnostics warnings;     ///< of odomd --check
  std::string wrote_database;            ///< "odomd.dbc", next to the configuration; empty: none
};

/// Writes options.out, once it has loaded as a configuration with its databases. Throws
/// std::invalid_argument that names file, line or option; then nothing is written.
[[nodiscard]] InitResult init(const InitOptions& options, Dialogue* dialogue);

}  // namespace odomd::tools
