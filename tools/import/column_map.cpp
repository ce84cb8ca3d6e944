#include "tools/import/column_map.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <numbers>
#include <span>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "can_protocol/decode/units.hpp"
#include "daemon/core/config_sections.hpp"
#include "tools/cli/csv.hpp"

namespace odomd::tools {
namespace {

using can::Unit;
using daemon::TableReader;

struct Field {
  std::string_view name;
  Quantity quantity;
};
constexpr std::array camera_fields{
    Field{"x", Quantity::length},        Field{"y", Quantity::length},
    Field{"yaw", Quantity::angle},       Field{"qx", Quantity::number},
    Field{"qy", Quantity::number},       Field{"qz", Quantity::number},
    Field{"qw", Quantity::number},       Field{"arrival", Quantity::time},
    Field{"latency", Quantity::seconds}, Field{"sigma_x", Quantity::length},
    Field{"sigma_y", Quantity::length},  Field{"sigma_yaw", Quantity::angle}};
constexpr std::array truth_fields{
    Field{"x", Quantity::length},       Field{"y", Quantity::length},
    Field{"yaw", Quantity::angle},      Field{"qx", Quantity::number},
    Field{"qy", Quantity::number},      Field{"qz", Quantity::number},
    Field{"qw", Quantity::number},      Field{"vx", Quantity::speed},
    Field{"vy", Quantity::speed},       Field{"yaw_rate", Quantity::yaw_rate},
    Field{"latitude", Quantity::angle}, Field{"longitude", Quantity::angle}};

/// Nothing if the unit is none of the quantity.
std::optional<double> factor_of(Quantity quantity, std::string_view unit) {
  if (unit == "1") return 1.0;
  if (quantity == Quantity::length) {
    constexpr std::array<std::pair<std::string_view, double>, 4> lengths{
        {{"m", 1.0}, {"cm", 1e-2}, {"mm", 1e-3}, {"km", 1e3}}};
    const auto found = std::ranges::find(lengths, unit, [](const auto& one) { return one.first; });
    return found == lengths.end() ? std::nullopt : std::optional(found->second);
  }
  if (quantity == Quantity::angle && unit == "min")  // of arc, as in a VBOX file
    return std::numbers::pi / 180.0 / 60.0;
  const auto known = can::unit_of_text(unit);
  using Units = std::pair<Unit, Unit>;
  const auto [si, other] = quantity == Quantity::angle   ? Units{Unit::rad, Unit::deg}
                           : quantity == Quantity::speed ? Units{Unit::m_per_s, Unit::km_per_h}
                           : quantity == Quantity::yaw_rate
                               ? Units{Unit::rad_per_s, Unit::deg_per_s}
                               : Units{Unit::none, Unit::none};
  if (known && (*known == si || *known == other)) return can::si_factor(*known);
  return quantity == Quantity::seconds && unit == "s" ? std::optional(1.0) : std::nullopt;
}

std::optional<double> number_in(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// The pieces of "a,unit=m/s": a comma in double quotes separates nothing.
std::vector<std::string> pieces_of(std::string_view text) {
  std::vector<std::string> pieces(1);
  bool quoted = false;
  for (const char c : text) {
    if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      pieces.emplace_back();
    else
      pieces.back() += c;
  }
  for (std::string& piece : pieces) {
    piece.erase(0, piece.find_first_not_of(' '));
    piece.erase(piece.find_last_not_of(' ') + 1);
  }
  return pieces;
}

/// { column = "a", unit = "m/s" } of "a,unit=m/s".
toml::table entry_of(std::string_view option, std::string_view text) {
  toml::table entry;
  const auto pieces = pieces_of(text);
  entry.insert("column", pieces.front());
  for (const std::string& piece : std::span(pieces).subspan(1)) {
    const auto equals = piece.find('=');
    if (equals == std::string::npos)
      throw std::invalid_argument(
          fmt::format("{} {}: {} is no KEY=VALUE; a name with a comma needs double quotes", option,
                      tools::quoted(text), tools::quoted(piece)));
    const std::string value = piece.substr(equals + 1);
    if (const auto number = number_in(value); number && piece.substr(0, equals) != "unit")
      entry.insert_or_assign(piece.substr(0, equals), *number);
    else
      entry.insert_or_assign(piece.substr(0, equals), value);
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

void add_option(toml::table& columns, const std::string& text) {
  const auto equals = text.find('=');
  const std::string role = text.substr(0, equals);
  if (equals == std::string::npos || role.empty())
    throw std::invalid_argument(
        fmt::format("--column {}: is no ROLE=COLUMN, as yaw_rate=gyro_z or camera.x=pose.x",
                    tools::quoted(text)));
  toml::table entry = entry_of("--column", std::string_view(text).substr(equals + 1));
  const auto point = role.find('.');
  if (point == std::string::npos) {
    columns.insert_or_assign(role, std::move(entry));
    return;
  }
  toml::table* group = columns[role.substr(0, point)].as_table();
  if (group == nullptr)
    group = columns.insert_or_assign(role.substr(0, point), toml::table{}).first->second.as_table();
  group->insert_or_assign(role.substr(point + 1), std::move(entry));
}

TimeColumn time_of(toml::table entry, const std::filesystem::path& file) {
  TableReader reader(entry, "time", file);
  TimeColumn time;
  reader.require("column");
  reader.read_texts("column", time.columns);
  if (time.columns.size() == 1)
    if (const auto plus = time.columns[0].find('+'); plus != std::string::npos)
      time.columns = {time.columns[0].substr(0, plus), time.columns[0].substr(plus + 1)};
  if (time.columns.size() > 2) reader.fail("column", "is more than seconds and nanoseconds");
  if (reader.has("unit")) {
    std::string unit;
    reader.read("unit", unit);
    const auto known = time_unit(unit);
    if (!known) reader.fail("unit", "is none of s, ms, us, ns, hhmmss");
    time.unit = *known;
  }
  reader.finish();
  return time;
}

std::string_view si_unit(std::string_view role) {
  if (role == "yaw_rate") return "rad/s";
  if (role == "steering") return "rad";
  return role.starts_with("accel_") ? "m/s2" : "m/s";
}

/// Keys of a role of [can.signals] that belong to the sensor, not to its frames.
constexpr std::array sensor_keys{"latency", "sigma", "timeout", "dead_band"};

SensorColumn sensor_of(const std::string& role, toml::table entry, const toml::table* configured,
                       const std::filesystem::path& file) {
  SensorColumn sensor;
  TableReader reader(entry, "[columns] " + role, file);
  reader.require("column");
  reader.read("column", sensor.column);
  if (sensor.column.empty()) reader.fail("column", "names no column");
  for (const char* key : {"unit", "radius", "ratio", "scale", "offset", "forward", "reverse"})
    static_cast<void>(reader.has(key));
  for (const char* key : sensor_keys) static_cast<void>(reader.has(key));
  reader.finish();

  entry.erase("column");
  sensor.unit_stated = entry.contains("unit") || role == "direction";
  if (!sensor.unit_stated) entry.insert("unit", si_unit(role));
  entry.insert("message", "table");
  entry.insert("signal", "column");
  for (const char* key : sensor_keys)
    if (configured != nullptr && configured->contains(key) && !entry.contains(key))
      entry.insert(key, *configured->get(key));
  daemon::CanConfig can;
  daemon::read_signal(role, TableReader(entry, "[columns] " + role, file), can);
  sensor.binding = can.bindings.front();
  sensor.settings = can.signals[sensor.binding.channel];
  return sensor;
}

PoseColumn field_of(std::string_view group, const std::string& name, std::span<const Field> fields,
                    const toml::table& entry, const std::filesystem::path& file) {
  TableReader reader(entry, fmt::format("[columns] {}.{}", group, name), file);
  const auto field = std::ranges::find(fields, name, &Field::name);
  if (field == fields.end()) {
    std::vector<std::string> names;
    for (const Field& one : fields) names.emplace_back(one.name);
    reader.fail("unknown column" + daemon::suggestion(name, names));
  }
  PoseColumn column{.field = name, .quantity = field->quantity};
  if (reader.has("value")) {
    reader.read("value", column.constant.emplace(), daemon::any_number);
  } else {
    reader.require("column");
    reader.read("column", column.column);
    if (column.column.empty()) reader.fail("column", "names no column");
    column.constant = number_in(column.column);
  }
  std::string unit = name == "latitude" || name == "longitude" ? "deg" : "1";
  column.unit_stated = reader.has("unit");
  reader.read("unit", unit);
  if (column.quantity == Quantity::time) {
    column.time_unit = time_unit(unit).value_or(TimeUnit::unstated);
  } else {
    const auto factor = factor_of(column.quantity, unit);
    if (!factor)
      reader.fail("unit", tools::quoted(unit) + " is none of this quantity; use a scale");
    column.factor = *factor;
    reader.read("scale", column.scale, daemon::any_number);
    reader.read("offset", column.offset, daemon::any_number);
  }
  reader.finish();
  return column;
}

void read_columns(const toml::table& columns, const toml::table& configured,
                  const std::filesystem::path& file, ColumnMap& map) {
  for (const auto& [key, node] : columns) {
    const std::string role(key.str());
    if (role != "camera" && role != "truth") {
      map.sensors.push_back(sensor_of(role, entry_of(node), configured[role].as_table(), file));
      continue;
    }
    if (!node.is_table())
      throw std::invalid_argument(
          fmt::format("{}: {} has fields: {}.x, {}.y, ...", file.string(), role, role, role));
    const bool is_camera = role == "camera";
    for (const auto& [field, entry] : *node.as_table())
      (is_camera ? map.camera : map.truth)
          .push_back(field_of(role, std::string(field.str()),
                              is_camera ? std::span<const Field>(camera_fields) : truth_fields,
                              entry_of(entry), file));
  }
}

}  // namespace

ColumnMap read_map(const MapSources& sources) {
  ColumnMap map;
  toml::table file;
  if (!sources.map.empty()) {
    file = daemon::parse_toml(daemon::read_toml_file(sources.map), sources.map);
    TableReader reader(file, "", sources.map);
    reader.read_texts("tables", map.tables);
    for (std::string& table : map.tables) table = (sources.map.parent_path() / table).string();
    static_cast<void>(reader.has("time"));
    static_cast<void>(reader.table("columns", "[columns]"));
    reader.finish();
  }
  toml::table config;
  if (!sources.config.empty())
    config = daemon::parse_toml(daemon::read_toml_file(sources.config), sources.config);
  toml::table none;
  const toml::table* configured = config["can"]["signals"].as_table();

  for (const std::string& text : sources.times)
    map.times.push_back(time_of(entry_of("--time", text), "--time"));
  if (const toml::array* several = file["time"].as_array())
    for (const auto& entry : *several) map.times.push_back(time_of(entry_of(entry), sources.map));
  else if (file.contains("time"))
    map.times.push_back(time_of(entry_of(*file.get("time")), sources.map));

  toml::table columns = file["columns"].is_table() ? *file["columns"].as_table() : toml::table{};
  for (const std::string& text : sources.columns) add_option(columns, text);
  read_columns(columns, configured != nullptr ? *configured : none,
               sources.map.empty() ? std::filesystem::path("--column") : sources.map, map);
  if (map.sensors.empty())
    throw std::invalid_argument(
        "no column is mapped to a role: give --column ROLE=COLUMN (yaw_rate, accel_x, accel_y, "
        "wheel_..., motor, steering, direction), or [columns] in a --map");
  std::ranges::sort(map.sensors, {}, [](const auto& one) { return one.binding.channel; });
  return map;
}

void use_unit_of_table(SensorColumn& column, std::string_view unit, const std::string& place) {
  if (column.unit_stated || unit.empty()) return;
  const auto known = can::unit_of_text(unit);
  if (!known && !can::is_other_unit(unit)) return;
  using Units = std::array<Unit, 3>;
  const Units fitting = column.binding.role == "yaw_rate" ? Units{Unit::rad_per_s, Unit::deg_per_s}
                        : column.binding.role == "steering" ? Units{Unit::rad, Unit::deg}
                        : column.binding.role.starts_with("accel_")
                            ? Units{Unit::m_per_s2, Unit::g}
                            : Units{Unit::m_per_s, Unit::km_per_h, Unit::rpm};
  if (!known || std::ranges::find(fitting, *known) == fitting.end())
    throw std::invalid_argument(fmt::format(
        "{}: its unit {} is none of {}; state another unit, or unit=1 with a scale to SI", place,
        tools::quoted(unit), column.binding.role));
  if (*known == Unit::rpm && column.binding.radius_m <= 0.0)
    throw std::invalid_argument(
        place +
        ": is in rpm; state unit=rpm with the wheel's radius=METRES, and for a motor ratio=");
  column.binding.unit = *known;
  column.unit_stated = true;
}

void use_unit_of_table(PoseColumn& column, std::string_view unit, const std::string& place) {
  if (column.unit_stated || unit.empty() || column.quantity == Quantity::time) return;
  if (const auto factor = factor_of(column.quantity, unit))
    column.factor = *factor;
  else if (can::unit_of_text(unit) || can::is_other_unit(unit))
    throw std::invalid_argument(
        fmt::format("{}: its unit {} is none of {}; state the unit, or a "
                    "scale with unit=1",
                    place, tools::quoted(unit), column.field));
}

}  // namespace odomd::tools
