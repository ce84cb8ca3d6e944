// odom-track implements odom identify track. It is a separate program, so that odom itself does not
// depend on OpenCV.
#include <algorithm>
#include <iostream>
#include <opencv2/core/utils/logger.hpp>
#include <string_view>

#include <fmt/format.h>

#include "tools/cli/command_line.hpp"
#include "tools/cli/files.hpp"
#include "tools/cli/output.hpp"
#include "tools/marker_tracking/film.hpp"
#include "tools/marker_tracking/film_renderer.hpp"
#include "tools/marker_tracking/options.hpp"

namespace odomd::tools {
namespace {

void report(const std::string& line) {
  say("odom identify track: " + line);
}

void track(const TrackOptions& options) {
  check(options);
  if (!options.calibrate.empty()) {
    for (const std::string& note : calibrate_lens(options)) report(note);
    return;
  }
  WholeFile file(options.out.empty() ? "-" : options.out);
  const TrackSummary summary = track_film(options, file.stream());
  file.finish();
  for (const std::string& note : summary.notes) report(note);
  report(fmt::format("{} frames; front marker in {}, rear marker in {}; longest gap {} frames",
                     summary.frames, summary.front, summary.rear, summary.longest_gap));
  if (10 * std::min(summary.front, summary.rear) < 9 * summary.frames)
    report(
        "warning: a marker is lost in more than a tenth of the frames: larger markers, more light, "
        "a shorter exposure");
}

}  // namespace
}  // namespace odomd::tools

// Called by odom sim --film as: odom-track render DRIVE FILM
int render(const char* drive, const char* film) {
  try {
    std::cout << "to track it: " << odomd::tools::render_film(drive, film) << std::endl;
    return odomd::tools::exit_done;
  } catch (const std::exception& error) {
    odomd::tools::say(std::string("odom sim: ") + error.what());
    return odomd::tools::exit_failed;
  }
}

int main(int argc, char** argv) {
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  if (argc == 4 && std::string_view(argv[1]) == "render") return render(argv[2], argv[3]);
  odomd::tools::TrackOptions options;
  const auto describe = [&options](odomd::tools::Command command) {
    command.program("odom identify track", "odom-track " ODOMD_VERSION);
    odomd::tools::describe_track(command, options);
    command.callback([&options] { odomd::tools::track(options); });
  };
  return odomd::tools::run_program(describe, argc, argv);
}
