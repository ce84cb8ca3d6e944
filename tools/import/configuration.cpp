// car.toml of an imported drive.
#include <algorithm>
#include <sstream>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "daemon/core/config_toml.hpp"
#include "tools/cli/json_text.hpp"
#include "tools/config_patch/toml_lines.hpp"
#include "tools/import/import.hpp"
#include "tools/init/writer.hpp"
#include "tools/sim/car_bus.hpp"

namespace odomd::tools {
namespace {

/// All of a configuration but [can], as its owner has it.
std::string own_tables(const std::filesystem::path& file) {
  toml::table config = daemon::parse_toml(daemon::read_toml_file(file), file);
  config.erase("can");
  std::ostringstream text;
  text << toml::default_formatter(config) << '\n';
  return text.str();
}

std::string vehicle(const CarTexts& texts) {
  Draft draft;
  draft.car = parse_car(texts);
  auto missing = required(missing_first(draft.car, draft.proposal));
  for (const Question& question : required(missing_last(draft.car, draft.proposal)))
    missing.push_back(question);
  if (!missing.empty()) refuse(missing);
  std::string text = "[vehicle]\n";
  for (const VehicleValue& value : vehicle_values(draft))
    text += fmt::format("{} = {} # {}{}\n", value.key, shortest(value.value),
                        value.sure ? "" : "UNSURE: ", value.origin);
  return text;
}

std::string role_line(const ImportedRole& role) {
  const MappedColumn& column = *role.column;
  // Three periods of the table; its stamps may be less regular than those of a bus.
  constexpr double min_timeout = 0.1, max_timeout = 60.0;
  const double timeout = column.settings.timeout_ns > 0
                             ? static_cast<double>(column.settings.timeout_ns) * 1e-9
                             : std::clamp(3.0 * role.period_s, min_timeout, max_timeout);
  std::string text = fmt::format(
      "{} = {{ message = \"{}\", signal = \"{}\", unit = \"{}\", sigma = {:.6g}, timeout = {:.3g}",
      column.role, role.message, role.signal, role.unit, column.settings.sigma, timeout);
  if (column.latency_ns > 0)
    text += fmt::format(", latency = {:.6g}", static_cast<double>(column.latency_ns) * 1e-9);
  if (column.settings.dead_band > 0.0)
    text += fmt::format(", dead_band = {:.6g}", column.settings.dead_band);
  if (role.has_bus) text += fmt::format(", bus = \"{}\"", bus_name(role.bus));
  return text + " }\n";
}

}  // namespace

std::string configuration_of(const ImportOptions& options, const ColumnMap& map,
                             const std::vector<ImportedRole>& roles) {
  const std::filesystem::path& own = options.map.config;
  std::string text = "# Made by odom import from ";
  for (const char c : fmt::format("{}", fmt::join(map.tables, ", ")))
    text += static_cast<unsigned char>(c) < ' ' ? '?' : c;
  text += ".\n\n" + (own.empty() ? vehicle(options.car) : own_tables(own));
  text += "\n[can]\nsource = \"drive.log\"\ndbc = \"car.dbc\"\n\n" + sim::bus_protection_text() +
          "\n# In SI units and to the left, ahead: what the columns were is worked in.\n"
          "[can.signals]\n";
  for (const ImportedRole& role : roles) text += role_line(role);
  if (!map.camera.empty() && text.find("\n[camera]") == std::string::npos)
    text +=
        "\n[camera]\nlever_arm = [0.0, 0.0, 0.0] # m, m, rad: the point whose pose is sent, from "
        "the centre of gravity, and its yaw\n";
  return text;
}

}  // namespace odomd::tools
