// The mapped sensor columns as frames of odomd.dbc.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "can_protocol/decode/message_encoder.hpp"
#include "can_protocol/frame.hpp"
#include "tools/import/read_tables.hpp"

namespace odomd::tools {

/// A role with its values in SI and its signal.
struct ImportedRole {
  std::string role;
  std::string place;  ///< "imu.csv: gyro_z"
  std::string_view message, signal;
  std::string_view unit;         ///< of the signal
  std::string_view column_unit;  ///< of the column
  bool unit_stated = true;       ///< by the map or the table
  std::string bus;               ///< empty: any
  std::size_t table = 0;
  std::vector<double> values;  ///< one per row of the table; NaN: missing
  std::size_t samples = 0, missing = 0, beyond = 0;
  double least = 0.0, most = 0.0;  ///< of the samples
  double period_s = 0.0;           ///< median time between samples
};

/// Roles whose values come and go together share the frames of a message. Otherwise a message is on
/// several buses, so that no value is sent twice.
struct FrameGroup {
  const can::Message* message = nullptr;
  std::uint8_t bus = 0;
  std::size_t table = 0;
  std::vector<std::size_t> roles;
};

struct SensorFrames {
  std::vector<ImportedRole> roles;  ///< in the order of the map
  std::vector<FrameGroup> groups;
  std::vector<std::string> warnings;
};

/// Values beyond a signal's range are left out and counted. Throws std::invalid_argument for a role
/// without a value, or with many beyond.
[[nodiscard]] SensorFrames to_frames(const ColumnMap& map, const Tables& tables);

[[nodiscard]] std::string bus_name(std::uint8_t bus);

/// All frames in the order of their stamps, each `shift_ns` later than its row.
void send_frames(const SensorFrames& sensors, const Tables& tables, std::int64_t shift_ns,
                 const std::function<void(const can::Frame&)>& send);

}  // namespace odomd::tools
