// odom import: writes the folder of a drive, as odom sim and odom record do, from tables.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/cli/output.hpp"
#include "tools/import/column_map.hpp"
#include "tools/init/proposal.hpp"
#include "tools/sim/drive_folder.hpp"

namespace odomd::tools {

struct ImportOptions {
  MapSources map;  ///< its config is the car's: car.toml has all its tables but [can]
  CarTexts car;    ///< used if there is no config
  std::filesystem::path out;
  sim::Existing existing = sim::Existing::keep;
};

struct ImportResult {
  nlohmann::ordered_json report;  ///< roles, frames, camera_poses, truth_rows, first, last
  diagnostics::Diagnostics warnings;
};

/// Writes drive.log, car.dbc and car.toml, and if mapped camera.csv and truth.csv, into
/// options.out: all of them or none. Throws std::invalid_argument that names file, line, column or
/// option.
[[nodiscard]] ImportResult import_drive(const ImportOptions& options, const ReportProgress& report);

/// A table of the roles.
[[nodiscard]] std::string as_text(const ImportResult& result);

}  // namespace odomd::tools
