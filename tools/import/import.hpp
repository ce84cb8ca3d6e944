// odom import: from tables to the folder of a drive, as odom sim and odom record write them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/import/column_map.hpp"
#include "tools/import/frames.hpp"
#include "tools/import/poses.hpp"
#include "tools/init/car.hpp"
#include "tools/init/init.hpp"

namespace odomd::tools {

struct ImportOptions {
  std::vector<std::string> tables;  ///< instead of the map's
  MapSources map;                   ///< its config is the car's: all tables of it but [can] stay
  CarTexts car;                     ///< without a config
  std::filesystem::path out;
  Overwrite overwrite = Overwrite::refuse;
};

struct ImportResult {
  SensorFrames sensors;
  std::size_t frames = 0;
  std::size_t camera_poses = 0, truth_rows = 0;
  std::int64_t first_ns = 0, last_ns = 0;  ///< of the frames
  diagnostics::Diagnostics warnings;
};

/// Writes drive.log, car.dbc and car.toml, and if mapped camera.csv and truth.csv, into
/// options.out: all of them or none. Throws std::invalid_argument that names file, line, column or
/// option.
[[nodiscard]] ImportResult import_drive(const ImportOptions& options, const ReportProgress& report);

[[nodiscard]] std::string as_text(const ImportResult& result);
[[nodiscard]] nlohmann::ordered_json as_json(const ImportResult& result);

/// The text of car.toml; without a config the numbers of the car come from its options.
[[nodiscard]] std::string configuration_of(const ImportOptions& options, const ColumnMap& map,
                                           const SensorFrames& sensors, bool has_camera);

}  // namespace odomd::tools
