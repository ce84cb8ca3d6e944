// odom import: makes a drive from tables.
#include "tools/import/import.hpp"
#include "tools/commands/commands.hpp"
#include "tools/diagnostics/output.hpp"

namespace odomd::tools {
namespace {

struct ImportArguments {
  ImportOptions import;
  bool json = false;
};

void run(const ImportArguments& options) {
  ProgressLine progress("odom import");
  const ImportResult result =
      import_drive(options.import, [&](const std::string& text) { progress.show(text); });
  progress.end();
  const std::string out = options.import.out.string();
  if (options.json) {
    auto json = result.report;
    json["out"] = out;
    json["diagnostics"] = as_json(result.warnings);
    std::cout << json_text(json, 2) << '\n';
    return;
  }
  warn("import", result.warnings);
  std::cout << as_text(result);
  const auto& report = result.report;
  say(
      fmt::format("odom import: {}: {:.1f} s, {} frames, {} camera poses, {} rows of truth; try: "
                  "odom doctor --drive {}",
                  out, report["last"].get<double>() - report["first"].get<double>(),
                  report["frames"].get<std::size_t>(), report["camera_poses"].get<std::size_t>(),
                  report["truth_rows"].get<std::size_t>(), out));
}

}  // namespace

void add_import(Command odom) {
  const auto options = std::make_shared<ImportArguments>();
  ImportOptions& import = options->import;
  Command command =
      odom.add_subcommand("import", "Make a drive from tables: a ROS bag's topics, a logger's CSV");
  command.add("CSV", "", import.map.tables, "Tables, merged by their times");
  command.add("--column", "ROLE=COLUMN[,KEY=VALUE]", import.map.columns,
              "A column for a role; repeatable. Keys: unit, scale, offset, ...", {one_each()});
  command.add("--time", "COLUMN[,unit=U]", import.map.times,
              "Column of the time, or SECONDS+NANOSECONDS; U: s, ms, us, ns or hhmmss; repeatable. "
              "Default: found from names and magnitudes",
              {one_each()});
  command.add("--config", "FILE", import.map.config,
              "Configuration of the car (TOML) to use for all but [can]; sigma, latency, timeout "
              "and dead_band of its roles are kept");
  command.add("--out", "DIR", import.out, "Folder to write", {required()});
  command.add_flag("--force", import.existing, sim::Existing::replace,
                   "Overwrite the drive in a folder that is not empty");
  command.add_flag("--json", options->json, "Print the report as JSON");
  const Command car = command.group("The car, without --config");
  car.add("--mass", "KG", import.car.mass, "Mass of the car as it drives; units: kg, g");
  car.add("--wheelbase", "M", import.car.wheelbase,
          "Distance from front to rear axle; units: m, cm, mm");
  car.add("--front-axle", "M", import.car.front_axle,
          "Distance from the centre of gravity to the front axle; default: half the wheelbase");
  car.add("--track", "M", import.car.track, "Left to right wheel");
  command.footer(
      "Roles are those of [can.signals]: yaw_rate, accel_x, accel_y, wheel_..., motor,\n"
      "steering; so are their keys: unit, radius, ratio, pole_pairs, scale (-1 inverts the\n"
      "sign), offset, sigma, latency, timeout, dead_band. Poses: camera.x, .y, .yaw (or .qx .qy\n"
      ".qz .qw), .sigma_x, .sigma_y, .sigma_yaw, .arrival or .latency; truth.x, .y, .yaw (or\n"
      "quaternion), .vx, .vy, .yaw_rate. A field of a pose may have a constant in place of a\n"
      "column: camera.sigma_x=0.01. imu.csv:NAME names the column of one of several tables.\n"
      "Units stated in the header or the row below it are used; otherwise SI is assumed.\n\n"
      "Examples:\n"
      "  odom import odom.csv imu.csv --out lap --config car.toml \\\n"
      "      --column motor=twist.twist.linear.x --column yaw_rate=angular_velocity.z\n"
      "  odom import logger.csv --out lap --mass 2.985 --wheelbase 0.26 --track 0.16 \\\n"
      "      --time 'T,unit=ms' --column 'wheel_rear=RPM,unit=rpm,radius=0.033' \\\n"
      "      --column 'yaw_rate=Gz,unit=deg/s,scale=-1'\n"
      "  odom import vbox.csv --out lap --config car.toml --time time,unit=hhmmss \\\n"
      "      --column wheel_rear=velocity,unit=km/h\n\n"
      "Exit status: 0 written, 2 unusable input; then nothing is written.");
  command.callback([options] { run(*options); });
}

}  // namespace odomd::tools
