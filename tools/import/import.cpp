#include "tools/import/import.hpp"

#include <algorithm>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/seconds.hpp"
#include "can_protocol/sources/candump.hpp"
#include "daemon/core/config.hpp"
#include "daemon/core/config_sections.hpp"
#include "tools/cli/files.hpp"
#include "tools/cli/text.hpp"
#include "tools/config_patch/config_patch.hpp"
#include "tools/init/init.hpp"

namespace odomd::tools {
namespace {

namespace fs = std::filesystem;

/// Names and texts; a file without a text is not written.
using Files = std::vector<std::pair<const char*, std::string>>;

/// Writes all files or none. Only files with other names remain from an earlier drive.
void write_files(const fs::path& folder, sim::Existing existing, const Files& files) {
  sim::make_drive_folder(folder, existing);
  std::vector<std::unique_ptr<WholeFile>> written;
  for (const auto& [name, text] : files) {
    if (text.empty()) continue;
    std::ostream& out = written.emplace_back(std::make_unique<WholeFile>(folder / name))->stream();
    if (!(out << text).flush())
      throw std::runtime_error(fmt::format("{}: {}", (folder / name).string(), why_unwritten(out)));
  }
  for (const auto& file : written) file->finish();
  for (const auto& [name, text] : files)
    if (text.empty()) fs::remove(folder / name);
}

/// Refuses tables whose times do not overlap: their clocks differ.
void require_common_time(const ColumnMap& map) {
  const TimedTable* first = nullptr;
  for (const TimedTable& rows : map.tables) {
    if (rows.times_ns.empty()) continue;
    if (first == nullptr) first = &rows;
    if (rows.times_ns.front() <= first->times_ns.back() &&
        rows.times_ns.back() >= first->times_ns.front())
      continue;
    const auto span = [](const TimedTable& one) {
      return fmt::format("{} ({}) from {} to {} s", one.name, one.time_column,
                         fixed(seconds(one.times_ns.front()), 3),
                         fixed(seconds(one.times_ns.back()), 3));
    };
    throw std::invalid_argument(fmt::format(
        "{}, {}: these have no time in common; name the time of one clock with --time FILE:COLUMN, "
        "or state its unit",
        span(*first), span(rows)));
  }
}

/// Adds whole seconds to all times so that none is negative, as in a log; returns what it added.
std::int64_t shift_times(ColumnMap& map) {
  constexpr std::int64_t second_ns = 1'000'000'000;
  std::int64_t first_ns = 0;
  for (const TimedTable& rows : map.tables)
    if (!rows.times_ns.empty()) first_ns = std::min(first_ns, rows.times_ns.front());
  const std::int64_t shift_ns = (-first_ns + second_ns - 1) / second_ns * second_ns;
  for (TimedTable& rows : map.tables)
    for (std::int64_t& time_ns : rows.times_ns) time_ns += shift_ns;
  return shift_ns;
}

/// The user's configuration without [can].
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
  require_numbers(draft.car, draft.proposal);
  std::string text = "[vehicle]\n";
  for (const VehicleValue& value : vehicle_values(draft))
    text += fmt::format("{} = {} # {}{}\n", value.key, shortest(value.value),
                        value.sure ? "" : "UNSURE: ", value.origin);
  return text;
}

std::string role_line(const ImportedRole& role) {
  const MappedColumn& column = *role.column;
  // The default is three periods of the table, as its stamps may be less regular than a bus's.
  constexpr double min_timeout = 0.1, max_timeout = 60.0;
  const double timeout = column.settings.timeout_ns > 0
                             ? seconds(column.settings.timeout_ns)
                             : std::clamp(3.0 * role.period_s, min_timeout, max_timeout);
  std::string text = fmt::format(
      "{} = {{ message = \"{}\", signal = \"{}\", unit = \"{}\", sigma = {:.6g}, timeout = {:.3g}",
      column.role, role.target->message, role.target->signal, role.target->unit,
      column.settings.sigma, timeout);
  if (column.latency_ns > 0) text += fmt::format(", latency = {:.6g}", seconds(column.latency_ns));
  if (column.settings.dead_band > 0.0)
    text += fmt::format(", dead_band = {:.6g}", column.settings.dead_band);
  if (role.has_bus) text += fmt::format(", bus = \"{}\"", bus_name(role.bus));
  return text + " }\n";
}

/// The text of car.toml; without a config, the car's numbers come from the command line.
std::string configuration_of(const ImportOptions& options, const ColumnMap& map,
                             const std::vector<ImportedRole>& roles, bool has_camera) {
  const std::filesystem::path& own = options.map.config;
  std::string text = "# Made by odom import from ";
  std::vector<std::string> names;
  std::ranges::transform(map.tables, std::back_inserter(names), &TimedTable::name);
  for (const char c : fmt::format("{}", fmt::join(names, ", ")))
    text += static_cast<unsigned char>(c) < ' ' ? '?' : c;
  text += ".\n\n" + (own.empty() ? vehicle(options.car) : own_tables(own));
  text += "\n[can]\nsource = \"drive.log\"\ndbc = \"car.dbc\"\n\n" + sim::bus_protection_text() +
          "\n# In SI units, positive forward and to the left: the columns are converted already.\n"
          "[can.signals]\n";
  for (const ImportedRole& role : roles) text += role_line(role);
  if (has_camera && text.find("\n[camera]") == std::string::npos)
    text +=
        "\n[camera]\nlever_arm = [0.0, 0.0, 0.0] # m, m, rad: the point whose pose is sent, from "
        "the centre of gravity, and its yaw\n";
  return text;
}

}  // namespace

ImportResult import_drive(const ImportOptions& options, const ReportProgress& report) {
  ColumnMap map = read_map(options.map);
  std::vector<std::string> warnings;
  read_tables(map, report, warnings);
  require_common_time(map);
  const std::int64_t shift_ns = shift_times(map);
  const std::vector<ImportedRole> roles = to_roles(map, warnings);
  if (shift_ns > 0)
    warnings.push_back(
        fmt::format("all times are {} s later than in the tables, where they are negative",
                    fixed(seconds(shift_ns), 0)));
  const PoseText camera = camera_of(map), truth = truth_of(map);
  for (const auto& [name, poses] : {std::pair("camera.csv", &camera), {"truth.csv", &truth}})
    if (poses->left_out > 0)
      warnings.push_back(fmt::format("{}: {} of {} rows lack a value and are left out", name,
                                     poses->left_out, poses->left_out + poses->rows));

  std::string log;
  const std::vector<can::Frame> frames = frames_of(roles, map);
  for (const can::Frame& frame : frames)
    can::append_candump_line(log, frame, bus_name(frame.bus), can::StampDecimals::nine);
  const std::string car = configuration_of(options, map, roles, !camera.text.empty());
  const daemon::Config config = daemon::parse_config(car, options.out / "car.toml");
  ImportResult result{.warnings = config.warnings};
  daemon::check_model(config, result.warnings);
  for (const std::string& warning : warnings)
    result.warnings.push_back(diagnostics::found(diagnostics::kind("file_content"), {}, warning));
  // car.dbc states no cycle times: the rows of a table need not be periodic.
  write_files(options.out, options.existing,
              {{"drive.log", std::move(log)},
               {"car.dbc", sim::bus_database_text([](std::string_view) { return 0; })},
               {"car.toml", car},
               {"camera.csv", camera.text},
               {"truth.csv", truth.text}});
  result.report["roles"] = nlohmann::ordered_json::array();
  for (const ImportedRole& role : roles) result.report["roles"].push_back(role.report);
  result.report["frames"] = frames.size();
  result.report["camera_poses"] = camera.rows;
  result.report["truth_rows"] = truth.rows;
  result.report["first"] = seconds(frames.front().time_ns);
  result.report["last"] = seconds(frames.back().time_ns);
  return result;
}

std::string as_text(const ImportResult& result) {
  Table table{{"role", "column", "unit", "samples", "missing", "1/s", "least", "most", "signal"},
              {},
              {0, 1, 2, 8}};
  for (const auto& role : result.report["roles"]) {
    const auto text = [&role](const char* key) { return role[key].get<std::string>(); };
    const auto number = [&role](const char* key) { return role[key].get<double>(); };
    table.rows.push_back({text("role"), text("column"),
                          text("unit") + (role["unit_stated"].get<bool>() ? "" : " assumed"),
                          fixed(number("samples"), 0), fixed(number("missing"), 0),
                          number("period") > 0.0 ? fixed(1.0 / number("period"), 1) : "-",
                          fixed(number("least"), 3), fixed(number("most"), 3),
                          text("message") + '.' + text("signal")});
  }
  return table.text();
}

}  // namespace odomd::tools
