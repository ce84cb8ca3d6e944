// odom import: converts the mapped columns of tables to frames of odomd.dbc, camera.csv and
// truth.csv, and writes the folder of a drive, as odom sim and odom record do.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/cli/output.hpp"
#include "tools/import/column_map.hpp"
#include "tools/init/proposal.hpp"
#include "tools/sim/car_bus.hpp"
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

/// A sensor's column and its signal.
struct ImportedRole {
  const MappedColumn* column = nullptr;
  const sim::BusRole* target = nullptr;
  std::uint8_t bus = 0;
  bool has_bus = false;   ///< the message is on several buses
  double period_s = 0.0;  ///< median time between samples
  nlohmann::ordered_json report;
};

/// One role per sensor of the map. Values beyond the signal's range then count as missing. Roles
/// whose values come together share a message; others use another bus, so that no value is sent
/// twice. Throws std::invalid_argument for a role without values, or with many beyond range.
[[nodiscard]] std::vector<ImportedRole> to_roles(ColumnMap& map,
                                                 std::vector<std::string>& warnings);

[[nodiscard]] std::string bus_name(std::uint8_t bus);

/// All frames in the order of their stamps.
[[nodiscard]] std::vector<can::Frame> frames_of(const std::vector<ImportedRole>& roles,
                                                const ColumnMap& map);

/// The text of a file. Rows with a missing value are left out.
struct PoseText {
  std::string text;  ///< empty: no column is mapped to it
  std::size_t rows = 0, left_out = 0;
};

/// Both throw std::invalid_argument that names the missing column.
[[nodiscard]] PoseText camera_of(const ColumnMap& map);
[[nodiscard]] PoseText truth_of(const ColumnMap& map);

}  // namespace odomd::tools
