// odom sim swing, odom sim weighing: experiments with a simulated car.
#include "tools/commands/commands.hpp"
#include "tools/sim/drive_folder.hpp"

namespace odomd::tools {
namespace {

using Experiment = nlohmann::ordered_json (*)(const sim::ExperimentOptions&);

struct ExperimentArguments {
  sim::ExperimentOptions options;
  bool json = false;
};

Command add_experiment(Command sim, const std::string& name, const std::string& sentence,
                       Experiment experiment,
                       const std::shared_ptr<ExperimentArguments>& arguments) {
  Command command = sim.add_subcommand(name, sentence);
  command.add("--out", "DIR", arguments->options.folder, "Folder for the results", {required()});
  command.add_flag("--force", arguments->options.existing, sim::Existing::replace,
                   "Overwrite the results in a folder that is not empty");
  command.add("--seed", "N", arguments->options.seed,
              "Seed of the car, the errors and the noise; default: 1");
  command.add_flag("--json", arguments->json, "Print the measurements as JSON");
  command.callback([arguments, experiment] {
    const nlohmann::ordered_json measured = experiment(arguments->options);
    if (arguments->json)
      std::cout << json_text(measured) << '\n';
    else
      std::cout << arguments->options.folder.string()
                << ": measured.json holds the measurements, plant.json the truth\n";
  });
  return command;
}

}  // namespace

void add_sim_experiments(Command sim) {
  const auto swing = std::make_shared<ExperimentArguments>();
  Command swing_command =
      add_experiment(sim, "swing", "Swing a simulated car on two cords, for odom identify inertia",
                     sim::simulate_swing, swing);
  swing_command.add("--duration", "T", swing->options.duration,
                    "Duration of the swinging [s]; default: 180");
  swing_command.footer(
      "The car is a rigid body on two slightly elastic cords; it sways and tilts, and does not\n"
      "hang exactly at its centre of gravity. Its gyro is written to drive.log as on a drive.\n"
      "measured.json contains lengths, mass and stop-watch timings, with the errors that people\n"
      "make; plant.json contains the true values.\n\n"
      "Examples:\n"
      "  odom sim swing --seed 7 --out swing\n"
      "  odom sim swing --duration 60 --out swing --force --json");
  const auto weighing = std::make_shared<ExperimentArguments>();
  add_experiment(sim, "weighing",
                 "Weigh a simulated car, for odom identify mass and odom identify cog",
                 sim::simulate_weighing, weighing)
      .footer(
          "The whole car, each axle and each side are weighed three times on a kitchen scale; the\n"
          "car is never quite level. measured.json contains the readings of scale and tape "
          "measure;\n"
          "plant.json contains the true values.\n\n"
          "Example:\n"
          "  odom sim weighing --seed 7 --out weighing --json");
}

}  // namespace odomd::tools
