#include "tools/import/column_map.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "can_protocol/decode/units.hpp"
#include "daemon/core/config_sections.hpp"
#include "tools/cli/csv.hpp"

namespace odomd::tools {
namespace {

using daemon::TableReader;

/// SI and one more unit.
struct Quantity {
  std::string_view si, other;
  double factor;
};
constexpr Quantity length{"m", "mm", 1e-3}, angle{"rad", "deg", std::numbers::pi / 180.0},
    speed{"m/s", "km/h", 1.0 / 3.6}, turning{"rad/s", "deg/s", angle.factor},
    number{"1", "%", 0.01}, duration{"s", "ms", 1e-3};

struct Field {
  std::string_view role;
  Quantity quantity;
};
constexpr std::array fields{Field{"camera.x", length},         Field{"camera.y", length},
                            Field{"camera.yaw", angle},        Field{"camera.qx", number},
                            Field{"camera.qy", number},        Field{"camera.qz", number},
                            Field{"camera.qw", number},        Field{"camera.arrival", duration},
                            Field{"camera.latency", duration}, Field{"camera.sigma_x", length},
                            Field{"camera.sigma_y", length},   Field{"camera.sigma_yaw", angle},
                            Field{"truth.x", length},          Field{"truth.y", length},
                            Field{"truth.yaw", angle},         Field{"truth.qx", number},
                            Field{"truth.qy", number},         Field{"truth.qz", number},
                            Field{"truth.qw", number},         Field{"truth.vx", speed},
                            Field{"truth.vy", speed},          Field{"truth.yaw_rate", turning}};

/// Keys of a role of [can.signals] that belong to the sensor, not to its frames.
constexpr std::array sensor_keys{"latency", "sigma", "timeout", "dead_band"};
constexpr std::array value_keys{"unit", "radius", "ratio", "pole_pairs", "scale", "offset"};

bool is_unit(std::string_view text, std::string_view unit) {
  const auto known = can::unit_of_text(unit);
  return text == unit || (known && can::unit_of_text(text) == known);
}

std::optional<double> number_in(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// { column = "a", unit = "m/s" } of "a,unit=m/s".
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
      const auto as_number = key == "unit" ? std::nullopt : number_in(value);
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

/// A name alone, or a number alone, in place of a table.
toml::table entry_of(const toml::node& node) {
  if (node.is_table()) return *node.as_table();
  toml::table entry;
  entry.insert(node.is_number() ? "value" : "column", node);
  return entry;
}

TimeColumn time_of(const toml::table& entry, const std::filesystem::path& file) {
  TableReader reader(entry, "time", file);
  TimeColumn time;
  reader.require("column");
  reader.read_texts("column", time.columns);
  if (time.columns.size() == 1)
    if (const auto plus = time.columns[0].find('+'); plus != std::string::npos)
      time.columns = {time.columns[0].substr(0, plus), time.columns[0].substr(plus + 1)};
  if (time.columns.size() > 2) reader.fail("column", "is more than seconds and nanoseconds");
  std::string unit;
  reader.read("unit", unit);
  time.unit = time_unit(unit);
  if (!unit.empty() && time.unit == TimeUnit::unstated)
    reader.fail("unit", "is none of s, ms, us, ns, hhmmss");
  reader.finish();
  return time;
}

MappedColumn column_of(std::string role, toml::table keys, const std::filesystem::path& file) {
  MappedColumn column{.role = std::move(role)};
  TableReader reader(keys, "[columns] " + column.role, file);
  const bool is_field = column.role.find('.') != std::string::npos;
  for (const char* key : value_keys) static_cast<void>(reader.has(key));
  for (const char* key : sensor_keys) static_cast<void>(reader.has(key));
  if (is_field && reader.has("value")) {
    reader.read("value", column.offset, daemon::any_number);
  } else {
    reader.require("column");
    reader.read("column", column.name);
    if (column.name.empty()) reader.fail("column", "names no column");
    if (const auto constant = number_in(column.name); constant && is_field) {
      column.offset = *constant;
      column.name.clear();
    }
  }
  reader.finish();
  keys.erase("column");
  keys.erase("value");
  column.keys = std::move(keys);
  return column;
}

std::string_view si_unit(std::string_view role) {
  return role == "yaw_rate"           ? "rad/s"
         : role == "steering"         ? "rad"
         : role.starts_with("accel_") ? "m/s2"
                                      : "m/s";
}

void read_sensor(MappedColumn& column, const std::filesystem::path& file) {
  const std::string name = "[columns] " + column.role;
  toml::table keys = column.keys;
  if (column.role == "direction")
    TableReader(keys, name, file).fail("is not read from tables; map a speed that has a sign");
  keys.insert("message", "table");
  keys.insert("signal", "column");
  daemon::CanConfig can;
  daemon::read_signal(column.role, TableReader(keys, name, file), can);
  const can::SignalBinding& binding = can.bindings.front();
  column.factor = binding.scale * can::si_factor(binding.unit);
  if (binding.radius_m > 0.0) column.factor *= binding.radius_m / binding.ratio;
  column.offset = binding.offset;
  column.unit = can::unit_name(binding.unit);
  column.latency_ns = binding.latency_ns;
  column.settings = can.signals[binding.channel];
}

void read_field(MappedColumn& column, const std::filesystem::path& file) {
  const Quantity& quantity = std::ranges::find(fields, column.role, &Field::role)->quantity;
  TableReader reader(column.keys, "[columns] " + column.role, file);
  reader.read("unit", column.unit);
  column.factor = 1.0;
  column.time_unit = time_unit(column.unit);
  if (is_unit(column.unit, quantity.other))
    column.factor = quantity.factor;
  else if (column.unit != "1" && !is_unit(column.unit, quantity.si) &&
           (column.role != "camera.arrival" || column.time_unit == TimeUnit::unstated))
    reader.fail("unit", fmt::format("{} is none of {}, {}; use unit = \"1\" and a scale",
                                    tools::quoted(column.unit), quantity.si, quantity.other));
  double scale = 1.0, offset = 0.0;
  reader.read("scale", scale, daemon::any_number);
  reader.read("offset", offset, daemon::any_number);
  reader.finish();
  column.factor *= scale;
  column.offset = column.factor * column.offset + offset;
}

/// "camera.x" of x in the table camera.
std::vector<std::pair<std::string, toml::table>> entries_in(const toml::table& columns,
                                                            const std::filesystem::path& file) {
  std::vector<std::pair<std::string, toml::table>> entries;
  for (const auto& [key, node] : columns) {
    const std::string role(key.str());
    if (role != "camera" && role != "truth") {
      entries.emplace_back(role, entry_of(node));
    } else if (node.is_table()) {
      for (const auto& [field, entry] : *node.as_table())
        entries.emplace_back(fmt::format("{}.{}", role, field.str()), entry_of(entry));
    } else {
      throw std::invalid_argument(
          fmt::format("{}: {} has fields: {}.x, {}.y, ...", file.string(), role, role, role));
    }
  }
  return entries;
}

void add_columns(const std::vector<std::pair<std::string, toml::table>>& entries,
                 const toml::table& configured, const std::filesystem::path& file, ColumnMap& map) {
  for (const auto& [role, entry] : entries) {
    MappedColumn column = column_of(role, entry, file);
    if (role.find('.') != std::string::npos) {
      if (std::ranges::find(fields, role, &Field::role) == fields.end()) {
        std::vector<std::string> names;
        for (const Field& field : fields) names.emplace_back(field.role);
        throw std::invalid_argument(fmt::format("{}: {}: unknown field{}", file.string(), role,
                                                daemon::suggestion(role, names)));
      }
      if (column.name.empty()) read_keys(column, "", file);
      (role.starts_with("camera") ? map.camera : map.truth).push_back(std::move(column));
      continue;
    }
    if (const toml::table* own = configured[role].as_table())
      for (const char* key : sensor_keys)
        if (own->contains(key) && !column.keys.contains(key))
          column.keys.insert(key, *own->get(key));
    map.sensors.push_back(std::move(column));
  }
}

}  // namespace

ColumnMap read_map(const MapSources& sources) {
  ColumnMap map{.file = sources.map.empty() ? std::filesystem::path("--column") : sources.map};
  toml::table file, config;
  if (!sources.map.empty()) {
    file = daemon::parse_toml(daemon::read_toml_file(sources.map), sources.map);
    TableReader reader(file, "", sources.map);
    reader.read_texts("tables", map.tables);
    for (std::string& table : map.tables) table = (sources.map.parent_path() / table).string();
    static_cast<void>(reader.has("time"));
    static_cast<void>(reader.table("columns", "[columns]"));
    reader.finish();
  }
  if (!sources.config.empty())
    config = daemon::parse_toml(daemon::read_toml_file(sources.config), sources.config);

  for (const std::string& text : sources.times)
    map.times.push_back(time_of(entry_of("--time", text), "--time"));
  if (const toml::array* several = file["time"].as_array())
    for (const auto& entry : *several) map.times.push_back(time_of(entry_of(entry), sources.map));
  else if (file.contains("time"))
    map.times.push_back(time_of(entry_of(*file.get("time")), sources.map));

  std::vector<std::pair<std::string, toml::table>> entries;
  if (const toml::table* columns = file["columns"].as_table())
    entries = entries_in(*columns, sources.map);
  for (const std::string& text : sources.columns) {
    const auto equals = text.find('=');
    const std::string role = text.substr(0, equals);
    if (equals == std::string::npos || role.empty())
      throw std::invalid_argument(
          fmt::format("--column {}: is no ROLE=COLUMN, as yaw_rate=gyro_z or camera.x=pose.x",
                      tools::quoted(text)));
    std::erase_if(entries, [&role](const auto& entry) { return entry.first == role; });
    entries.emplace_back(role, entry_of("--column", text.substr(equals + 1)));
  }
  const toml::table* configured = config["can"]["signals"].as_table();
  add_columns(entries, configured != nullptr ? *configured : toml::table{}, map.file, map);
  if (map.sensors.empty())
    throw std::invalid_argument(
        "no column is mapped to a role: give --column ROLE=COLUMN (yaw_rate, accel_x, accel_y, "
        "wheel_..., motor, steering), or [columns] in a --map");
  return map;
}

void read_keys(MappedColumn& column, std::string_view unit_of_table,
               const std::filesystem::path& file) {
  const bool is_field = column.role.find('.') != std::string::npos;
  column.unit_stated = column.keys.contains("unit");
  if (!column.unit_stated) {
    column.unit_stated = can::unit_of_text(unit_of_table) || can::is_other_unit(unit_of_table);
    column.keys.insert("unit", column.unit_stated ? unit_of_table
                               : is_field         ? "1"
                                                  : si_unit(column.role));
  }
  is_field ? read_field(column, file) : read_sensor(column, file);
}

}  // namespace odomd::tools
