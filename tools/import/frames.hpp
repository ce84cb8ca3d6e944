// The mapped sensor columns as frames of odomd.dbc.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "can_protocol/frame.hpp"
#include "tools/import/read_tables.hpp"

namespace odomd::tools {

/// A sensor's column and its signal.
struct ImportedRole {
  const MappedColumn* column = nullptr;
  std::string_view message, signal, unit;
  std::uint8_t bus = 0;
  bool has_bus = false;        ///< the message is on several
  std::vector<double> values;  ///< NaN: missing, or beyond the signal's range
  std::size_t samples = 0, missing = 0, beyond = 0;
  double least = 0.0, most = 0.0;  ///< of the samples
  double period_s = 0.0;           ///< median time between samples
};

/// One per sensor of the map. Roles whose values come together share a message; otherwise it is on
/// several buses, so that no value is sent twice. Throws std::invalid_argument for a role without a
/// value, or with many beyond.
[[nodiscard]] std::vector<ImportedRole> to_roles(const ColumnMap& map,
                                                 const std::vector<TableRows>& tables,
                                                 std::vector<std::string>& warnings);

[[nodiscard]] std::string bus_name(std::uint8_t bus);

/// All frames in the order of their stamps, each `shift_ns` later than its row.
void send_frames(const std::vector<ImportedRole>& roles, const std::vector<TableRows>& tables,
                 std::int64_t shift_ns, const std::function<void(const can::Frame&)>& send);

}  // namespace odomd::tools
