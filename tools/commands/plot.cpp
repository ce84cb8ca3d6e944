// odom plot: one picture of pose files, or of the running daemon.
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "tools/chart/picture.hpp"
#include "tools/cli/command.hpp"
#include "tools/cli/daemon_options.hpp"
#include "tools/cli/output.hpp"
#include "tools/commands/commands.hpp"
#include "tools/diagnostics/output.hpp"
#include "tools/drive_files/innovation_file.hpp"
#include "tools/report/figures.hpp"
#include "tools/report/plot_charts.hpp"

namespace odomd::tools {
namespace {

// The subjects that a picture may show: a quantity of the poses, or the contents of other files.
std::vector<std::string> subjects() {
  std::vector<std::string> all = plot_quantities();
  all.insert(all.end(), {"innovation", "beat"});
  return all;
}

struct Options {
  std::vector<std::string> files;
  std::vector<std::string> what;
  std::string reference;
  std::string out;
  std::string title;
  Frame frame = Frame::map;
  double seconds = 0.0;  // how long to follow the running daemon; 0: plot files
  std::string shm;
};

using Drawings = std::vector<chart::Drawing>;

void append(Drawings& to, const Drawings& from) {
  to.insert(to.end(), from.begin(), from.end());
}

const std::string& only_file(const Options& options, const std::string& what) {
  if (options.files.size() != 1) {
    throw std::invalid_argument("--what " + what + ": takes one file only");
  }
  return options.files.front();
}

Drawings innovations_of(const Options& options) {
  if (options.seconds > 0.0) {
    throw std::invalid_argument(
        "--what innovation: the daemon does not keep innovations; record the drive, and plot the "
        "file of odom replay --innovations");
  }
  const auto judgements = read_innovations(only_file(options, "innovation"));
  Drawings drawings;
  for (const chart::Chart& chart : innovation_charts(judgements, judgements.front().time_ns)) {
    drawings.push_back(draw(chart));
  }
  if (drawings.empty()) {
    throw std::invalid_argument(options.files.front() + ": no sample in it was tested");
  }
  return drawings;
}

Drawings beat_of(const BeatHistogram& beat) {
  Drawings drawings;
  for (const Figure& figure : beat_charts(beat)) drawings.push_back(figure.drawing);
  return drawings;
}

// The source of the poses, read on first use.
class Source {
 public:
  explicit Source(const Options& options) : options_(options) {}

  [[nodiscard]] const PlotInput& poses() {
    if (!input_) read();
    return *input_;
  }
  [[nodiscard]] BeatHistogram beat() {
    if (options_.seconds == 0.0) return read_beat_log(only_file(options_, "beat"));
    if (!input_) read();
    return beat_;
  }

 private:
  void read() {
    PlotInput& input = input_.emplace();
    if (options_.seconds > 0.0) {
      LiveTrack live =
          follow_daemon(options_.shm, options_.seconds, options_.frame, plot_columns());
      input.tracks.push_back(std::move(live.track));
      beat_ = live.beat;
    }
    for (const std::string& file : options_.files) {
      input.tracks.push_back(read_trajectory(file, options_.frame, plot_columns()));
    }
    if (!options_.reference.empty()) {
      input.reference = read_trajectory(options_.reference, Frame::map, plot_columns());
      warn("plot", input.reference->warnings);
      if (std::ranges::find(options_.what, "calibrations") != options_.what.end())
        input.truth = true_calibrations(std::filesystem::path{options_.reference}.parent_path());
    }
    for (const Trajectory& track : input.tracks) warn("plot", track.warnings);
    if (!overlap(input)) warn("plot", "the files have no time in common; each begins at 0 s");
  }

  const Options& options_;
  std::optional<PlotInput> input_;
  BeatHistogram beat_;
};

void run_plot(const Options& options) {
  chart::check_picture(options.out);
  Drawings drawings;
  if (!options.title.empty()) drawings.push_back(chart::heading(options.title));
  Source source(options);
  for (const std::string& subject :
       options.what.empty() ? std::vector<std::string>{"trajectory"} : options.what)
    append(drawings, subject == "innovation" ? innovations_of(options)
                     : subject == "beat"     ? beat_of(source.beat())
                                             : plot(subject, source.poses()));
  chart::write_picture(options.out, drawings);
}

}  // namespace

void add_plot(Command odom) {
  auto options = std::make_shared<Options>();
  Command command =
      odom.add_subcommand("plot", "Draw pose files, or the poses of the running daemon");
  command.add("CSV", "TEXT", options->files,
              "Pose files of odom replay, or references (t,x,y,yaw)");
  command.add("--out", "FILE", options->out,
              "Picture to write, .svg or .png; -: SVG to standard output", {required()});
  const std::string names = fmt::format("{}", fmt::join(subjects(), "|"));
  command.add("--what", names, options->what,
              "Quantity to draw; repeatable, one below the other; default: trajectory. beat is the "
              "timing of the ticks",
              {repeatable(), checked([names](const std::string& name) -> std::string {
                 const std::vector<std::string> all = subjects();
                 if (std::ranges::find(all, name) != all.end()) return "";
                 return "\"" + name + "\" cannot be drawn; available: " + names;
               })});
  command.add("--reference", "CSV", options->reference,
              "Reference trajectory, drawn in grey; of odom sim: also the true calibrations");
  command.add_choice(
      "--frame", options->frame, {{"map", Frame::map}, {"odom", Frame::odom}},
      "Frame of the pose: the map, or the odometry frame without jumps; default: map");
  command.add("--title", "TEXT", options->title, "Title of the picture");
  command.add("--for", "S", options->seconds,
              "Follow the running daemon for this time [s], instead of files",
              {positive(), excludes("CSV")});
  add_segment_option(command, options->shm, SegmentElse::default_names, {needs("--for")});
  command.footer(
      "Examples:\n"
      "  odom plot pose.csv --out lap.svg\n"
      "  odom plot kinematic.csv full.csv --reference truth.csv --out lap.png\n"
      "  odom plot pose.csv --what speed --what yaw_rate --what calibrations --out drive.svg\n"
      "  odom plot --for 10 --what speed --what beat --out now.png\n"
      "  odom plot innovations.csv --what innovation --out innovations.svg\n"
      "Poses are drawn as they are; odom evaluate --picture aligns them with the reference first.\n"
      "For innovation give the file of odom replay --innovations, for beat the beat.csv of a "
      "recording.");
  command.callback([options] {
    if (options->files.empty() && options->seconds == 0.0) {
      require("A pose file or --for");
    }
    run_plot(*options);
  });
}

}  // namespace odomd::tools
