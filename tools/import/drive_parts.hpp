// Converts the mapped columns to frames of odomd.dbc, camera.csv and truth.csv.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tools/import/column_map.hpp"
#include "tools/sim/car_bus.hpp"

namespace odomd::tools {

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
