#include "tools/import/import.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <system_error>

#include <fmt/format.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include "can_protocol/sources/candump.hpp"
#include "daemon/core/config.hpp"
#include "tools/cli/csv.hpp"
#include "tools/cli/files.hpp"
#include "tools/cli/text.hpp"
#include "tools/drive_files/camera_csv.hpp"
#include "tools/sim/car_bus.hpp"

namespace odomd::tools {
namespace {

namespace fs = std::filesystem;
using diagnostics::found;
using diagnostics::kind;

constexpr std::int64_t second_ns = 1'000'000'000;

/// Files that are written side by side and then moved to their folder, all or none.
class WholeFolder {
 public:
  WholeFolder(fs::path folder, Overwrite overwrite)
      : folder_(std::move(folder)), written_(fmt::format("{}.partial-{}", trimmed(), ::getpid())) {
    std::error_code error;
    if (fs::exists(folder_, error) && !fs::is_directory(folder_, error))
      throw std::invalid_argument(folder_.string() + ": is not a directory");
    if (fs::exists(folder_, error) && !fs::is_empty(folder_, error) &&
        overwrite == Overwrite::refuse)
      throw std::invalid_argument(folder_.string() +
                                  ": is not empty; give another directory, or replace the drive "
                                  "in it with --force");
    fs::create_directories(written_, error);
    if (error)
      throw std::invalid_argument(folder_.string() + ": cannot be created: " + error.message());
  }
  ~WholeFolder() {
    std::error_code ignored;
    fs::remove_all(written_, ignored);
  }
  WholeFolder(const WholeFolder&) = delete;
  WholeFolder& operator=(const WholeFolder&) = delete;

  template <typename Write>
  void write(const char* name, Write&& write_to) {
    WholeFile file(written_ / name);
    write_to(file.stream());
    file.finish();
  }
  [[nodiscard]] fs::path file(const char* name) const { return written_ / name; }

  /// Of an earlier drive only files of other names stay.
  void finish() {
    std::error_code error;
    if (!fs::exists(folder_, error)) return fs::rename(written_, folder_);
    for (const char* name : {"drive.log", "car.dbc", "car.toml", "camera.csv", "truth.csv"}) {
      if (fs::exists(written_ / name))
        fs::rename(written_ / name, folder_ / name);
      else
        fs::remove(folder_ / name);
    }
  }

 private:
  [[nodiscard]] std::string trimmed() const {
    std::string name = folder_.string();
    while (name.size() > 1 && name.back() == '/') name.pop_back();
    return name;
  }

  fs::path folder_;
  fs::path written_;
};

/// Tables on other clocks do not meet.
void require_common_time(const Tables& tables) {
  const auto used = [](const TableRows& rows) { return !rows.times_ns.empty(); };
  const auto first = std::ranges::find_if(tables.rows, used);
  for (const TableRows& rows : tables.rows) {
    if (!used(rows) || (rows.times_ns.front() <= first->times_ns.back() &&
                        rows.times_ns.back() >= first->times_ns.front()))
      continue;
    std::string times;
    for (const TableRows* one : {&*first, &rows})
      times +=
          fmt::format("{}{} ({}) from {} to {} s", times.empty() ? "" : ", ", one->name,
                      one->time_column, fixed(static_cast<double>(one->times_ns.front()) * 1e-9, 3),
                      fixed(static_cast<double>(one->times_ns.back()) * 1e-9, 3));
    throw std::invalid_argument(times +
                                ": these have no time in common; name the time of one clock with "
                                "--time FILE:COLUMN, or state its unit");
  }
}

void append_values(std::string& text, std::initializer_list<double> values) {
  for (const double value : values) {
    text += ',';
    append_number(text, value);
  }
}

void write_log(const SensorFrames& sensors, const Tables& tables, std::int64_t shift_ns,
               std::ostream& out, ImportResult& result) {
  std::string text;
  send_frames(sensors, tables, shift_ns, [&](const can::Frame& frame) {
    text.clear();
    can::append_candump_line(text, frame, bus_name(frame.bus), can::StampDecimals::nine);
    out << text;
    if (result.frames++ == 0) result.first_ns = frame.time_ns;
    result.last_ns = frame.time_ns;
  });
}

void write_camera(const ImportedCamera& camera, std::int64_t shift_ns, std::ostream& out) {
  out << camera_columns << '\n';
  std::string text;
  for (estimator::CameraPose pose : camera.poses) {
    pose.arrival_ns += shift_ns;
    pose.capture_ns += shift_ns;
    text.clear();
    append_camera_row(text, pose);
    out << text;
  }
}

void write_truth(const ImportedTruth& truth, std::int64_t shift_ns, std::ostream& out) {
  out << (truth.has_motion ? "t,x,y,yaw,vx,vy,yaw_rate\n" : "t,x,y,yaw\n");
  std::string text;
  for (const ImportedTruth::Row& row : truth.rows) {
    text.clear();
    append_seconds(text, row.time_ns + shift_ns);
    append_values(text, {row.x, row.y, row.yaw});
    if (truth.has_motion) append_values(text, {row.motion[0], row.motion[1], row.motion[2]});
    out << text << '\n';
  }
}

/// Stamps of a log are not negative.
std::int64_t shift_of(const Tables& tables) {
  std::int64_t first = 0;
  for (const TableRows& rows : tables.rows)
    if (!rows.times_ns.empty()) first = std::min(first, rows.times_ns.front());
  return (-first + second_ns - 1) / second_ns * second_ns;
}

void warn_of_rows(const Tables& tables, const ImportedCamera& camera, const ImportedTruth& truth,
                  std::int64_t shift_ns, diagnostics::Diagnostics& warnings) {
  const auto warn = [&](const std::string& subject, const std::string& seen) {
    warnings.push_back(found(kind("file_content"), subject, seen));
  };
  for (const TableRows& rows : tables.rows)
    if (rows.without_time > 0)
      warn(rows.name, fmt::format("{} without a time left out", counted(rows.without_time, "row")));
  if (camera.left_out > 0)
    warn("camera.csv", fmt::format("{} of {} rows lack a value and are left out", camera.left_out,
                                   camera.left_out + camera.poses.size()));
  if (truth.left_out > 0)
    warn("truth.csv", fmt::format("{} of {} rows lack a value and are left out", truth.left_out,
                                  truth.left_out + truth.rows.size()));
  if (shift_ns > 0)
    warn("drive.log", fmt::format("all times are {} s later than in the tables, where they are "
                                  "negative",
                                  shift_ns / second_ns));
}

}  // namespace

ImportResult import_drive(const ImportOptions& options, const ReportProgress& report) {
  ColumnMap map = read_map(options.map);
  if (!options.tables.empty()) map.tables = options.tables;
  WholeFolder folder(options.out, options.overwrite);
  const Tables tables = read_tables(map, report);
  require_common_time(tables);
  ImportResult result;
  result.sensors = to_frames(map, tables);
  const ImportedCamera camera = camera_of(map, tables);
  const ImportedTruth truth = truth_of(map, tables);
  const std::int64_t shift_ns = shift_of(tables);
  for (const std::string& warning : result.sensors.warnings)
    result.warnings.push_back(found(kind("file_content"), {}, warning));
  warn_of_rows(tables, camera, truth, shift_ns, result.warnings);
  result.camera_poses = camera.poses.size();
  result.truth_rows = truth.rows.size();

  const std::string text = configuration_of(options, map, result.sensors, !map.camera.empty());
  daemon::Config config = daemon::parse_config(text, options.out / "car.toml");
  // The rows of a table come as they come.
  folder.write("car.dbc", [](std::ostream& out) {
    out << sim::bus_database_text([](std::string_view) { return 0; });
  });
  config.can.dbc = {folder.file("car.dbc")};
  diagnostics::Diagnostics of_config = config.warnings;
  static_cast<void>(daemon::load_databases(config, of_config));
  append(result.warnings, of_config);
  folder.write("car.toml", [&](std::ostream& out) { out << text; });
  folder.write("drive.log", [&](std::ostream& out) {
    write_log(result.sensors, tables, shift_ns, out, result);
  });
  if (!map.camera.empty())
    folder.write("camera.csv", [&](std::ostream& out) { write_camera(camera, shift_ns, out); });
  if (!map.truth.empty())
    folder.write("truth.csv", [&](std::ostream& out) { write_truth(truth, shift_ns, out); });
  folder.finish();
  return result;
}

std::string as_text(const ImportResult& result) {
  Table table{
      {"role", "column", "unit", "samples", "missing", "1/s", "least", "most", "SI", "signal"},
      {},
      {0, 1, 2, 8, 9}};
  for (const ImportedRole& role : result.sensors.roles)
    table.rows.push_back({role.role, role.place,
                          std::string(role.column_unit) + (role.unit_stated ? "" : " assumed"),
                          std::to_string(role.samples), std::to_string(role.missing),
                          role.period_s > 0.0 ? fixed(1.0 / role.period_s, 1) : "-",
                          fixed(role.least, 3), fixed(role.most, 3), std::string(role.unit),
                          fmt::format("{}.{}{}{}", role.message, role.signal,
                                      role.bus.empty() ? "" : " on ", role.bus)});
  return table.text();
}

nlohmann::ordered_json as_json(const ImportResult& result) {
  using nlohmann::ordered_json;
  ordered_json roles = ordered_json::array();
  for (const ImportedRole& role : result.sensors.roles) {
    roles.push_back({{"role", role.role},
                     {"column", role.place},
                     {"unit", role.column_unit},
                     {"unit_stated", role.unit_stated},
                     {"message", role.message},
                     {"signal", role.signal},
                     {"samples", role.samples},
                     {"missing", role.missing},
                     {"beyond", role.beyond},
                     {"period", role.period_s},
                     {"least", role.least},
                     {"most", role.most}});
    if (!role.bus.empty()) roles.back()["bus"] = role.bus;
  }
  return {{"roles", std::move(roles)},
          {"frames", result.frames},
          {"camera_poses", result.camera_poses},
          {"truth_rows", result.truth_rows},
          {"first", static_cast<double>(result.first_ns) * 1e-9},
          {"last", static_cast<double>(result.last_ns) * 1e-9}};
}

}  // namespace odomd::tools
