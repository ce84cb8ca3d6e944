#include "tools/import/column_map.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "can_protocol/decode/units.hpp"
#include "daemon/core/config_sections.hpp"
#include "tools/cli/csv.hpp"

namespace odomd::tools {
namespace {

using daemon::TableReader;

constexpr const char* option_name = "--column";  // in messages

const std::vector<std::string> fields{
    "camera.x",       "camera.y",         "camera.yaw",     "camera.qx",      "camera.qy",
    "camera.qz",      "camera.qw",        "camera.arrival", "camera.latency", "camera.sigma_x",
    "camera.sigma_y", "camera.sigma_yaw", "truth.x",        "truth.y",        "truth.yaw",
    "truth.qx",       "truth.qy",         "truth.qz",       "truth.qw",       "truth.vx",
    "truth.vy",       "truth.yaw_rate"};

/// The role whose units the field has; empty for a length, time or number.
std::string role_like(const MappedColumn& column) {
  const std::string& role = column.role;
  if (column.is_sensor()) return role;
  if (role.ends_with("yaw_rate")) return "yaw_rate";
  if (role.ends_with("yaw")) return "steering";
  return role.ends_with(".vx") || role.ends_with(".vy") ? "motor" : "";
}

std::string_view si_unit(std::string_view role) {
  const auto source = std::ranges::find(estimator::source_names, role);
  if (source == estimator::source_names.end()) return "1";
  const auto index = source - estimator::source_names.begin();
  return can::unit_name(daemon::units_of(static_cast<estimator::Source>(index)).front());
}

/// Keys of a role of [can.signals] that belong to the sensor, not to its frames.
constexpr std::array sensor_keys{"latency", "sigma", "timeout", "dead_band"};
constexpr std::array value_keys{"unit", "radius", "ratio", "pole_pairs", "scale", "offset"};

/// { column = "a", unit = "m/s" } for "a,unit=m/s".
toml::table entry_of(std::string_view option, const std::string& text) {
  toml::table entry;
  std::vector<std::string_view> pieces;
  std::string copy = text;
  split_cells(copy, {.quote = '"'}, pieces);
  for (const std::string_view piece : pieces) {
    const auto equals = piece.find('=');
    if (entry.empty()) {
      entry.insert("column", piece);
    } else if (equals == std::string_view::npos) {
      throw std::invalid_argument(
          fmt::format("{} {}: {} is no KEY=VALUE; a name with a comma needs double quotes", option,
                      tools::quoted(text), tools::quoted(piece)));
    } else {
      const std::string_view key = piece.substr(0, equals), value = piece.substr(equals + 1);
      const auto as_number = key == "unit" ? std::nullopt : parse_number(value);
      if (!as_number)
        entry.insert_or_assign(key, value);
      else if (value.find_first_not_of("0123456789") == std::string_view::npos)
        entry.insert_or_assign(key, static_cast<std::int64_t>(*as_number));
      else
        entry.insert_or_assign(key, *as_number);
    }
  }
  return entry;
}

TimeColumn time_of(const std::string& text) {
  const toml::table entry = entry_of("--time", text);
  TableReader reader(entry, "time", "--time");
  std::string column, unit;
  reader.require("column");
  reader.read("column", column);
  reader.read("unit", unit);
  TimeColumn time{.columns = {column}, .unit = time_unit(unit)};
  if (const auto plus = column.find('+'); plus != std::string::npos)
    time.columns = {column.substr(0, plus), column.substr(plus + 1)};
  if (!unit.empty() && time.unit == TimeUnit::unstated)
    reader.fail("unit", "is none of s, ms, us, ns, hhmmss");
  reader.finish();
  return time;
}

/// The column, with missing sensor keys taken from its role in the configuration.
MappedColumn column_of(const std::string& role, toml::table keys, const toml::table* configured) {
  MappedColumn column{.role = role};
  TableReader reader(keys, role, option_name);
  if (!column.is_sensor() && std::ranges::find(fields, role) == fields.end())
    reader.fail("unknown field" + daemon::suggestion(role, fields));
  for (const char* key : value_keys) static_cast<void>(reader.has(key));
  if (column.is_sensor())
    for (const char* key : sensor_keys) static_cast<void>(reader.has(key));
  reader.require("column");
  reader.read("column", column.name);
  if (column.name.empty()) reader.fail("column", "names no column");
  reader.finish();
  keys.erase("column");
  for (const char* key : sensor_keys)
    if (configured != nullptr && configured->contains(key) && !keys.contains(key))
      keys.insert(key, *configured->get(key));
  column.keys = std::move(keys);
  if (const auto constant = parse_number(column.name); constant && !column.is_sensor()) {
    read_keys(column, "");
    column.offset += column.factor * *constant;
    column.name.clear();
  }
  return column;
}

}  // namespace

ColumnMap read_map(const MapSources& sources) {
  ColumnMap map;
  toml::table config;
  if (!sources.config.empty())
    config = daemon::parse_toml(daemon::read_toml_file(sources.config), sources.config);
  for (const std::string& table : sources.tables) map.tables.push_back({.name = table});
  for (const std::string& text : sources.times) map.times.push_back(time_of(text));
  for (const std::string& text : sources.columns) {
    const auto equals = text.find('=');
    const std::string role = text.substr(0, equals);
    if (equals == std::string::npos || role.empty())
      throw std::invalid_argument(
          fmt::format("--column {}: is no ROLE=COLUMN, as yaw_rate=gyro_z or camera.x=pose.x",
                      tools::quoted(text)));
    std::erase_if(map.columns, [&role](const MappedColumn& column) { return column.role == role; });
    map.columns.push_back(column_of(role, entry_of(option_name, text.substr(equals + 1)),
                                    config["can"]["signals"][role].as_table()));
  }
  if (std::ranges::none_of(map.columns, &MappedColumn::is_sensor))
    throw std::invalid_argument(
        "no column is mapped to a role: give --column ROLE=COLUMN (yaw_rate, accel_x, accel_y, "
        "wheel_..., motor, steering)");
  return map;
}

void read_keys(MappedColumn& column, std::string_view unit_of_table) {
  const std::string name = column.role, like = role_like(column);
  toml::table keys = column.keys;
  column.unit_stated = keys.contains("unit") || can::unit_of_text(unit_of_table) ||
                       can::is_other_unit(unit_of_table);
  keys.insert("unit", column.unit_stated ? unit_of_table : si_unit(like));
  TableReader reader(keys, name, option_name);
  reader.read("unit", column.unit);
  if (like == "direction") reader.fail("is not read from tables; map a speed that has a sign");
  double factor = 1.0;
  if (like.empty()) {
    column.time_unit = time_unit(column.unit);
    if (column.unit == "mm" || column.unit == "cm" || column.unit == "ms")
      factor = column.unit == "cm" ? 1e-2 : 1e-3;
    else if (column.unit != "1" && column.unit != "m" && column.time_unit == TimeUnit::unstated)
      reader.fail("unit", tools::quoted(column.unit) + " is none of m, cm, mm, s, ms; use a scale");
    keys.insert_or_assign("unit", "1");
    keys.insert("scale", 1.0);
  }
  keys.insert("message", "table");
  keys.insert("signal", "column");
  daemon::CanConfig can;
  daemon::read_signal(like.empty() ? "motor" : like, TableReader(keys, name, option_name), can);
  const can::SignalBinding& binding = can.bindings.front();
  column.factor = factor * binding.scale * can::si_factor(binding.unit);
  if (binding.radius_m > 0.0) column.factor *= binding.radius_m / binding.ratio;
  column.offset = binding.offset;
  column.latency_ns = binding.latency_ns;
  column.settings = can.signals[binding.channel];
}

}  // namespace odomd::tools
