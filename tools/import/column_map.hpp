// Which columns of tables are what: the map of odom import, from a TOML file and from options.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "can_protocol/decode/signal_binding.hpp"
#include "daemon/core/config.hpp"
#include "tools/import/time_column.hpp"

namespace odomd::tools {

/// A column that a role of [can.signals] is made of. Keys and arithmetic are those of a role.
struct SensorColumn {
  std::string column;
  can::SignalBinding binding;  ///< without message and signal
  daemon::SignalSettings settings;
  bool unit_stated = false;
};

enum class Quantity : std::uint8_t { length, angle, speed, yaw_rate, number, seconds, time };

/// A column, or a number instead of one, that a field of camera poses or of the truth is made of:
/// scale * factor * value + offset.
struct PoseColumn {
  std::string field;  ///< "x"
  Quantity quantity = Quantity::number;
  std::string column;
  std::optional<double> constant;
  double factor = 1.0;  ///< of the unit
  double scale = 1.0, offset = 0.0;
  bool unit_stated = false;
  TimeUnit time_unit = TimeUnit::unstated;
};

struct ColumnMap {
  std::vector<std::string> tables;
  std::vector<TimeColumn> times;
  std::vector<SensorColumn> sensors;
  std::vector<PoseColumn> camera, truth;
};

struct MapSources {
  std::filesystem::path map;
  std::vector<std::string> columns;  ///< "yaw_rate=gyro_z,unit=deg/s"; go before the map's
  std::vector<std::string> times;    ///< "stamp.sec+stamp.nanosec", "t,unit=ms"
  std::filesystem::path config;  ///< its roles' latency, sigma, timeout, dead_band are the defaults
};

/// Throws std::invalid_argument that names file, line and key.
[[nodiscard]] ColumnMap read_map(const MapSources& sources);

/// Takes over the unit that a table states where the map states none; place is "imu.csv: gyro_z".
/// Throws std::invalid_argument if that is none of the quantity.
void use_unit_of_table(SensorColumn& column, std::string_view unit, const std::string& place);
void use_unit_of_table(PoseColumn& column, std::string_view unit, const std::string& place);

}  // namespace odomd::tools
