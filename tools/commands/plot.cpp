// odom plot: one picture of pose files, or of the running daemon.
#include <fmt/ranges.h>

#include <iterator>

#include "tools/chart/picture.hpp"
#include "tools/commands/commands.hpp"
#include "tools/diagnostics/output.hpp"
#include "tools/drive_files/drive_tables.hpp"
#include "tools/report/figures.hpp"

namespace odomd::tools {
namespace {

// The subjects that a picture may show: a quantity of the poses, or the contents of other files.
std::vector<std::string> subjects() {
  std::vector<std::string> all = plot_quantities();
  all.insert(all.end(), {"innovation", "beat"});
  return all;
}

struct PlotOptions {
  std::vector<std::string> files;
  std::vector<std::string> what;
  std::string reference;
  std::string out;
  std::string title;
  Frame frame = Frame::map;
  double seconds = 0.0;  // how long to follow the running daemon; 0: plot files
  std::string shm;
};

// A file that does not hold poses, such as the beat.
const std::string& only_file(const PlotOptions& options, const std::string& what) {
  if (options.files.size() != 1)
    throw std::invalid_argument("--what " + what + ": takes one file only");
  return options.files.front();
}

std::vector<Figure> innovations_of(const std::string& file) {
  const auto judgements = read_innovations(file);
  std::vector<Figure> figures;
  for (const chart::Chart& chart : innovation_charts(judgements, judgements.front().time_ns))
    figures.push_back({.drawing = draw(chart)});
  if (figures.empty()) throw std::invalid_argument(file + ": no sample in it was tested");
  return figures;
}

// Reads the poses and, from a running daemon, the beat.
PlotInput read_input(const PlotOptions& options, std::optional<odom_beat>& beat) {
  PlotInput input;
  if (options.seconds > 0.0) {
    LiveTrack live = follow_daemon(options.shm, options.seconds, options.frame, plot_columns());
    input.tracks.push_back(std::move(live.track));
    beat = live.beat;
  }
  for (const std::string& file : options.files)
    input.tracks.push_back(read_trajectory(file, options.frame, plot_columns()));
  if (!options.reference.empty()) {
    input.reference = read_trajectory(options.reference, Frame::map, plot_columns());
    warn("plot", input.reference->warnings);
    if (std::ranges::find(options.what, "calibrations") != options.what.end())
      input.truth = true_calibrations(std::filesystem::path{options.reference}.parent_path());
  }
  for (const Trajectory& track : input.tracks) warn("plot", track.warnings);
  if (!overlap(input)) warn("plot", "the files have no time in common; each begins at 0 s");
  return input;
}

void run_plot(const PlotOptions& options) {
  chart::check_picture(options.out);
  const bool live = options.seconds > 0.0;
  std::vector<chart::Drawing> drawings;
  if (!options.title.empty()) drawings.push_back(chart::heading(options.title));
  std::optional<PlotInput> input;
  std::optional<odom_beat> beat;
  for (const std::string& subject : options.what) {
    const bool of_file = subject == "innovation" || subject == "beat";
    if (subject == "innovation" && live)
      throw std::invalid_argument(
          "--what innovation: the daemon does not keep innovations; record the drive, and plot the "
          "file of odom replay --innovations");
    if (!input && (live || !of_file)) input = read_input(options, beat);
    if (subject == "beat" && !live) beat = read_beat_log(only_file(options, subject));
    if (!of_file)
      std::ranges::move(plot(subject, *input), std::back_inserter(drawings));
    else
      for (Figure& figure :
           subject == "beat" ? beat_charts(*beat) : innovations_of(only_file(options, subject)))
        drawings.push_back(std::move(figure.drawing));
  }
  chart::write_picture(options.out, drawings);
}

}  // namespace

void add_plot(Command odom) {
  auto options = std::make_shared<PlotOptions>();
  Command command =
      odom.add_subcommand("plot", "Draw pose files, or the poses of the running daemon");
  command.add("CSV", "TEXT", options->files,
              "Pose files of odom replay, or references (t,x,y,yaw)");
  command.add("--out", "FILE", options->out,
              "Picture to write, .svg or .png; -: SVG to standard output", {required()});
  const std::string names = fmt::format("{}", fmt::join(subjects(), "|"));
  command.add("--what", names, options->what,
              "Quantity to draw; repeatable: the plots are stacked; default: trajectory. beat is "
              "the timing of the ticks",
              {repeatable(), checked([names](const std::string& name) -> std::string {
                 const std::vector<std::string> all = subjects();
                 if (std::ranges::find(all, name) != all.end()) return "";
                 return "\"" + name + "\" cannot be drawn; available: " + names;
               })});
  command.add("--reference", "CSV", options->reference,
              "Reference trajectory, drawn in grey; a truth.csv of odom sim also gives the true "
              "calibrations");
  command.add_choice(
      "--frame", options->frame, {{"map", Frame::map}, {"odom", Frame::odom}},
      "Frame of the pose: the map, or the odometry frame without jumps; default: map");
  command.add("--title", "TEXT", options->title, "Title of the picture");
  command.add("--for", "S", options->seconds,
              "Plot the running daemon for this time [s] instead of files",
              {positive(), excludes("CSV")});
  add_segment_option(command, options->shm, SegmentElse::default_names, {needs("--for")});
  command.footer(
      "Examples:\n"
      "  odom plot pose.csv --out lap.svg\n"
      "  odom plot kinematic.csv full.csv --reference truth.csv --out lap.png\n"
      "  odom plot pose.csv --what speed --what yaw_rate --what calibrations --out drive.svg\n"
      "  odom plot --for 10 --what speed --what beat --out now.png\n"
      "  odom plot innovations.csv --what innovation --out innovations.svg\n"
      "Poses are drawn as they are; odom evaluate --picture aligns them with the reference\n"
      "first. innovation needs the file that odom replay --innovations writes, beat the\n"
      "beat.csv of a recording.");
  command.callback([options] {
    if (options->files.empty() && options->seconds == 0.0) {
      require("A pose file or --for");
    }
    if (options->what.empty()) options->what = {"trajectory"};
    run_plot(*options);
  });
}

}  // namespace odomd::tools
