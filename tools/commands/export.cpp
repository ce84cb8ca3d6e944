// odom export: writes a drive for viewers.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "tools/cli/command.hpp"
#include "tools/cli/files.hpp"
#include "tools/cli/output.hpp"
#include "tools/commands/commands.hpp"
#include "tools/diagnostics/output.hpp"
#include "tools/export/drive_data.hpp"
#include "tools/export/formats.hpp"
#include "tools/replay/log_options.hpp"

namespace odomd::tools {
namespace {

struct Options {
  std::string source;
  ExportSources files;
  std::string mcap;
  std::string csv;
  std::string tum;
  ExportTime time = ExportTime::absolute;
  McapCompression compression = McapCompression::zstd;
};

std::vector<std::filesystem::path> inputs_of(const Options& options, const ExportSources& sources) {
  std::vector<std::filesystem::path> inputs{options.source, sources.pose, sources.config,
                                            sources.camera, sources.truth};
  inputs.insert(inputs.end(), sources.logs.begin(), sources.logs.end());
  inputs.insert(inputs.end(), sources.databases.begin(), sources.databases.end());
  return inputs;
}

void export_drive(const Options& options) {
  ExportSources sources = options.source.empty() ? ExportSources{} : sources_in(options.source);
  const ExportSources& named = options.files;
  if (!named.pose.empty()) sources.pose = named.pose;
  if (!named.config.empty()) sources.config = named.config;
  if (!named.logs.empty()) sources.logs = named.logs;
  if (!named.databases.empty()) sources.databases = named.databases;
  if (!named.camera.empty()) sources.camera = named.camera;
  if (!named.truth.empty()) sources.truth = named.truth;
  sources.damage = named.damage;

  check_outputs(std::vector<Output>{{"--mcap", options.mcap}, {"--csv", options.csv}},
                inputs_of(options, sources));
  if (std::filesystem::path(options.mcap).extension() == ".csv")
    throw std::invalid_argument("--mcap: " + options.mcap +
                                " looks like a table by its name; use --csv for a table");
  const DriveData data = read_drive(sources);
  warn("export", data.warnings);
  const ExportTime time = options.time;
  if (!options.csv.empty()) {
    WholeFile file(options.csv);
    write_plot_csv(data.poses, time, file.stream());
    file.finish();
    say(fmt::format("odom export: {}: {} poses, {} columns", options.csv,
                    data.poses.times_ns.size(), data.poses.fields.size() + 1));
  }
  if (!options.mcap.empty()) {
    WholeFile file(options.mcap);
    const McapStatistics statistics = write_mcap(data, time, options.compression, file.stream());
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
  for (const auto& [name, text] : tum_files(data, time)) {
    write_whole(folder / name, text);
    say("odom export: " + (folder / name).string());
  }
}

}  // namespace

void add_export(Command odom) {
  auto options = std::make_shared<Options>();
  Command command = odom.add_subcommand(
      "export", "Export a drive to Foxglove (MCAP), PlotJuggler (CSV), evo (TUM)");
  command.add("--drive,SOURCE", "SOURCE", options->source,
              "Pose file, folder of odom record, or folder with a drive (drive.log or can.log, "
              "car.toml, camera.csv, truth.csv, pose.csv)");
  command.add("--mcap", "FILE", options->mcap, "MCAP file to write, for Foxglove");
  command.add("--csv", "FILE", options->csv, "CSV file to write, the poses for PlotJuggler");
  command.add("--tum", "DIR", options->tum,
              "Folder to write trajectories into, for evo: pose.tum, odometry.tum, camera.tum, "
              "truth.tum, as far as the drive has them");
  command.add_flag("--relative-time", options->time, ExportTime::relative,
                   "Write times [s] since the beginning of the drive instead of the files' times");
  command.add_choice("--compression", options->compression,
                     {{"zstd", McapCompression::zstd}, {"none", McapCompression::none}},
                     "Compression of the MCAP file; default: zstd");
  command.add("--pose", "CSV", options->files.pose, "Pose file; instead of the source's");
  command.add("--config", "FILE", options->files.config,
              "Configuration of the car (TOML); instead of the source's");
  command.add("--can", "LOG", options->files.logs,
              "Log of candump -L; repeatable, for several buses; instead of the source's");
  command.add("--dbc", "DBC", options->files.databases,
              "Database (DBC); repeatable; instead of [can] dbc");
  command.add("--camera", "CSV", options->files.camera, "Camera log; instead of the source's");
  command.add("--truth", "CSV", options->files.truth,
              "Reference trajectory (t,x,y,yaw); instead of the source's");
  add_strict(command, options->files.damage);
  command.footer(
      "Examples:\n"
      "  odom export drive-20261121-140300 --mcap drive.mcap\n"
      "  odom export pose.csv --csv plot.csv --relative-time\n"
      "  odom export lap --pose pose.csv --mcap lap.mcap\n"
      "  odom export lap --tum tum && evo_ape tum tum/truth.tum tum/pose.tum\n"
      "  odom export --config car.toml --can drive.log --truth truth.csv --mcap drive.mcap\n"
      "A drive with frames and a configuration but no poses is replayed to get them.\n"
      "docs/bridge.md lists the topics.");
  command.callback([options] {
    if (options->mcap.empty() && options->csv.empty() && options->tum.empty())
      require("--mcap, --csv or --tum");
    export_drive(*options);
  });
}

}  // namespace odomd::tools
