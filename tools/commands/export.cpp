// odom export: writes a drive for viewers.
#include "tools/export/export.hpp"
#include "tools/commands/commands.hpp"
#include "tools/diagnostics/output.hpp"
#include "tools/replay/drive.hpp"
#include "tools/replay/log_options.hpp"

namespace odomd::tools {
namespace {

struct ExportOptions {
  ExportSource source;
  std::string mcap;
  std::string csv;
  std::string tum;
};

void export_drive(const ExportOptions& options) {
  const ExportSource& source = options.source;
  std::vector<std::filesystem::path> inputs{source.drive, source.pose};
  if (std::filesystem::is_directory(source.drive))
    for (const auto& file : files_of({.folder = source.drive, .config = source.config}))
      inputs.push_back(file);
  check_outputs(std::vector<Output>{{"--mcap", options.mcap}, {"--csv", options.csv}}, inputs);
  if (std::filesystem::path(options.mcap).extension() == ".csv")
    throw std::invalid_argument("--mcap: " + options.mcap +
                                " looks like a table by its name; use --csv for a table");
  const DriveData data = read_drive(source);
  warn("export", data.warnings);
  if (!options.csv.empty()) {
    WholeFile file(options.csv);
    write_plot_csv(data.poses, file.stream());
    file.finish();
    say(fmt::format("odom export: {}: {} poses, {} columns", options.csv,
                    data.poses.times_ns.size(), data.poses.fields.size() + 1));
  }
  if (!options.mcap.empty()) {
    WholeFile file(options.mcap);
    const McapStatistics statistics = write_mcap(data, file.stream());
    file.finish();
    say(fmt::format("odom export: {}: {} messages on {} topics, {:.1f} MB", options.mcap,
                    statistics.messages, statistics.topics,
                    static_cast<double>(statistics.bytes) * 1e-6));
  }
  if (options.tum.empty()) return;
  const std::filesystem::path folder = options.tum;
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw std::invalid_argument("--tum: " + options.tum + ": " + error.message());
  for (const auto& [name, text] : tum_files(data)) {
    write_whole(folder / name, text);
    say("odom export: " + (folder / name).string());
  }
}

}  // namespace

void add_export(Command odom) {
  auto options = std::make_shared<ExportOptions>();
  Command command = odom.add_subcommand(
      "export", "Export a drive to Foxglove (MCAP), PlotJuggler (CSV), evo (TUM)");
  command.add("--drive,SOURCE", "SOURCE", options->source.drive,
              "Pose file, or folder with a drive (drive.log or can.log, car.toml, and camera.csv, "
              "truth.csv, pose.csv if they exist)",
              {required()});
  command.add("--mcap", "FILE", options->mcap, "MCAP file to write, for Foxglove");
  command.add("--csv", "FILE", options->csv, "CSV file to write, with the poses, for PlotJuggler");
  command.add("--tum", "DIR", options->tum,
              "Folder to write trajectories into, for evo: pose.tum, odometry.tum, camera.tum and "
              "truth.tum, as far as the drive has them");
  command.add("--pose", "CSV", options->source.pose, "Pose file; instead of the folder's pose.csv");
  command.add("--config", "FILE", options->source.config,
              "Configuration of the car (TOML); instead of the folder's car.toml");
  add_strict(command, options->source.damage);
  command.footer(
      "Examples:\n"
      "  odom export drive-20261121-140300 --mcap drive.mcap\n"
      "  odom export pose.csv --csv plot.csv\n"
      "  odom export lap --pose pose.csv --mcap lap.mcap\n"
      "  odom export lap --tum tum && evo_ape tum tum/truth.tum tum/pose.tum\n"
      "A folder without poses is replayed to get them.\n"
      "docs/bridge.md lists the topics.");
  command.callback([options] {
    if (options->mcap.empty() && options->csv.empty() && options->tum.empty())
      require("--mcap, --csv or --tum");
    export_drive(*options);
  });
}

}  // namespace odomd::tools
