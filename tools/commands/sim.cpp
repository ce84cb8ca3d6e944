// odom sim: drives a simulated car, into a folder or live.
#include <cmath>

#include "tools/cli/csv.hpp"
#include "tools/commands/commands.hpp"
#include "tools/sim/car/plant.hpp"
#include "tools/sim/drive_folder.hpp"
#include "tools/sim/live.hpp"
#include "tools/sim/simulation.hpp"

namespace odomd::tools {
namespace {

struct SimArguments {
  sim::RunOptions run;
  std::vector<std::optional<double>> sizes =
      std::vector<std::optional<double>>(sim::parameter_count);
  std::vector<std::string> fixed;
  std::vector<std::string> dropouts;
  std::string car;
  std::string start_time;
  std::string out;
  std::string can;
  std::string camera_socket;
  bool servo = false;
  bool list = false;
  bool live = false;
  sim::Existing existing = sim::Existing::keep;
  bool config_only = false;
  sim::FilmMarkers markers = sim::FilmMarkers::leave_out;
  std::string film;
  bool json = false;
  bool progress = false;
};

sim::RunOptions run_options(const SimArguments& arguments) {
  sim::RunOptions run = arguments.run;
  if (!arguments.car.empty()) run.car = sim::find_car(arguments.car);
  if (arguments.servo) run.sizes = sim::slow_servo();
  for (const sim::ParameterInfo& info : sim::parameter_table())
    if (const auto& size = arguments.sizes[static_cast<std::size_t>(info.parameter)])
      run.sizes.push_back({info.parameter, *size});
  for (const std::string& text : arguments.fixed) run.fixed.push_back(sim::parse_assignment(text));
  for (const std::string& text : arguments.dropouts)
    run.dropouts.push_back(sim::parse_dropout(text));
  if (arguments.live) {
    run.start_ns = sim::live_start_ns();
  } else if (!arguments.start_time.empty()) {
    const auto start = parse_seconds(arguments.start_time);
    if (!start || *start < sim::truth_period_ns)
      throw std::invalid_argument("--start-time: \"" + arguments.start_time +
                                  "\" is not a time in seconds, 0.005 or more");
    run.start_ns = *start / sim::truth_period_ns * sim::truth_period_ns;
  }
  return run;
}

void list_scenarios() {
  for (const sim::Scenario& scenario : sim::all_scenarios())
    std::cout << fmt::format("{:<12}  {} ({:g} m/s, {} {})\n", scenario.name, scenario.sentence,
                             scenario.speed, scenario.laps, scenario.laps == 1 ? "lap" : "laps");
}

// What a drive has sent, for its summary.
struct Counts {
  std::uint64_t frames = 0;
  std::uint64_t camera = 0;
};

void report(const SimArguments& arguments, const sim::RunPlan& plan, const sim::Simulation& drive,
            const Counts& counts) {
  const sim::PlantOutput& end = drive.plant().output();
  const double duration = 1e-9 * static_cast<double>(drive.time_ns());
  const double apart = std::hypot(end.x - plan.start.x, end.y - plan.start.y);
  if (arguments.json) {
    nlohmann::ordered_json result = sim::describe(plan);
    result["duration"] = duration;
    result["distance"] = drive.driver().progress();
    result["end_to_start"] = apart;
    result["frames"] = counts.frames;
    result["camera_poses"] = counts.camera;
    std::cout << json_text(result, 2) << '\n';
    return;
  }
  const std::string text = fmt::format(
      "{}: {:.1f} s, {:.1f} m, ends {:.3f} m from the start, {} frames, {} camera poses\n",
      arguments.run.scenario, duration, drive.driver().progress(), apart, counts.frames,
      counts.camera);
  // Standard output may be used as the bus.
  if (arguments.live)
    std::cerr << "odom sim: " << text;
  else
    std::cout << text;
}

void simulate(const SimArguments& arguments) {
  if (arguments.list) return list_scenarios();
  const std::string can = arguments.can.empty() && arguments.live ? "-" : arguments.can;
  if (!arguments.live && !arguments.config_only && !can.empty())
    throw std::invalid_argument(
        "--can needs --live; without --live the frames go to DIR/drive.log");
  if (!arguments.live && !arguments.config_only && !arguments.camera_socket.empty())
    throw std::invalid_argument("--camera-socket needs --live or --config-only");
  if (arguments.markers == sim::FilmMarkers::write && arguments.out.empty())
    throw std::invalid_argument("--markers: the film goes to a folder; add --out DIR");
  if (!arguments.film.empty() && (arguments.out.empty() || arguments.config_only))
    throw std::invalid_argument("--film: renders the drive in a folder; add --out DIR");
  if (!arguments.live && arguments.out.empty())
    throw std::invalid_argument("no output: give --out DIR, or --live; see odom sim --help");
  if (arguments.live && can == "-" && arguments.json)
    throw std::invalid_argument(
        "--json and the frames would both go to standard output; --out DIR "
        "writes the same to plant.json");

  const sim::RunPlan plan = sim::make_plan(run_options(arguments));
  std::optional<sim::DriveWriter> writer;
  if (!arguments.out.empty()) {
    sim::make_drive_folder(arguments.out, arguments.existing);
    // A relative path in the configuration would be relative to the configuration's folder.
    const std::string& socket = arguments.camera_socket;
    sim::write_car_files(
        arguments.out, plan,
        {.can = can.empty() ? "drive.log" : can,
         .camera_socket = socket.empty() ? socket : std::filesystem::absolute(socket).string()});
    if (arguments.config_only) return;
    writer.emplace(arguments.out, arguments.live && can != "-" ? can : sim::log_interface,
                   arguments.markers);
  }

  sim::Simulation drive(plan);
  Counts counts;
  const auto take = [&](const sim::Happenings& happenings) {
    counts.frames += happenings.frames.size();
    counts.camera += happenings.camera.size();
    if (writer) writer->write(happenings);
  };
  ProgressLine progress("odom sim", arguments.progress || arguments.live
                                        ? WithoutTerminal::every_second
                                        : WithoutTerminal::nothing);
  if (arguments.live) {
    const sim::LiveSummary summary = sim::play_live(
        drive,
        {.start_ns = plan.options.start_ns, .can = can, .camera_socket = arguments.camera_socket},
        progress, take);
    if (!arguments.camera_socket.empty())
      std::cerr << "odom sim: " << summary.camera_sent << " camera poses sent, "
                << summary.camera_dropped << " not taken by the daemon\n";
    if (summary.end == sim::LiveEnd::interrupted) std::cerr << "odom sim: interrupted\n";
  } else {
    sim::RunState state = sim::RunState::running;
    while (state == sim::RunState::running) {
      sim::Happenings happenings;
      state = drive.advance(drive.time_ns() + 100 * sim::truth_period_ns, happenings);
      take(happenings);
      progress.show(sim::progress_text(drive));
    }
    progress.finish(sim::progress_text(drive));
  }
  if (writer) writer->close();
  report(arguments, plan, drive, counts);
  if (arguments.film.empty()) return;
  std::cout.flush();
  become("odom-track", {"render", arguments.out, arguments.film},
         "--film needs odom-track: install the package odom-track, or libopencv-dev, and configure "
         "and build again; the drive is in " +
             arguments.out);
}

std::string scenario_names() {
  std::string names;
  for (const sim::Scenario& scenario : sim::all_scenarios())
    if (names.find(scenario.name) == std::string::npos)
      names += (names.empty() ? "" : "|") + std::string(scenario.name);
  return names;
}

void add_parameter_options(Command command, SimArguments& arguments) {
  for (const sim::ParameterInfo& info : sim::parameter_table()) {
    std::string option = "--" + std::string(info.name);
    for (char& letter : option)
      if (letter == '_') letter = '-';
    std::string defaults;
    append_number(defaults, info.scale_car);
    if (info.saloon != info.scale_car) {
      defaults += ", saloon ";
      append_number(defaults, info.saloon);
    }
    if (info.published != info.saloon)
      defaults += fmt::format(", published cars {:.4g}", info.published);
    const std::string relative =
        info.unit == "1" && info.draw != sim::Draw::exact ? ", relative" : "";
    const std::string_view draw = info.draw == sim::Draw::normal    ? ", standard deviation"
                                  : info.draw == sim::Draw::uniform ? ", uniform within +-X"
                                                                    : "";
    const std::string unit = info.unit == "1" ? relative : fmt::format(" [{}]", info.unit);
    std::string help = fmt::format("{}{}{}; default: {}", info.meaning, draw, unit, defaults);
    if (help.front() >= 'a' && help.front() <= 'z')
      help.front() = static_cast<char>(help.front() - 32);
    command.group(std::string(info.group))
        .add(option, "X", arguments.sizes[static_cast<std::size_t>(info.parameter)], help);
  }
}

}  // namespace

void add_sim(Command odom) {
  auto arguments = std::make_shared<SimArguments>();
  Command command =
      odom.add_subcommand("sim", "Simulate a drive, into a folder or live in real time");
  command.footer(
      "The car differs from the model of every filter: its tyres saturate, load shifts, wheels\n"
      "slip, and the steering lags. The errors of its sensors are sampled from the seed and\n"
      "written to DIR/plant.json. The same options and seed give bit-identical results.\n\n"
      "Examples:\n"
      "  odom sim --out drive\n"
      "  odom sim --scenario slalom --speed 2 --seed 7 --camera-outliers 0.01 --out drive\n"
      "  odom sim --ideal --gyro-scale-error 0.03 --out drive\n"
      "  odom sim --fix gyro_bias=0.01 --camera-dropout 20:2 --camera-dropout 40:5 --out drive\n"
      "  odom sim --car bmw_320i --scenario slalom --speed 12 --out drive\n"
      "  odom sim --scenario circles --markers --out circles\n"
      "  odom sim --scenario circles --laps 1 --film circles.avi --film-rate 25 --out circles\n"
      "  odom sim --live --can vcan0 --camera-socket /run/odomd/vcan0/camera.sock --out drive\n"
      "  odom sim --config-only --out drive\n"
      "  odom sim --live --out drive --force |\n"
      "      odomd --config drive/car.toml --can - --exit-at-end");

  command.add_flag("--list", arguments->list, "List the scenarios");
  command.add("--scenario", scenario_names(), arguments->run.scenario,
              "Scenario to drive; default: lap");
  command.add("--speed", "V", arguments->run.speed,
              "Speed on the straights [m/s]; default: the scenario's");
  command.add("--car", sim::car_names(), arguments->car,
              "Car: scale (1:10), saloon (on rigid springs), or a published car (bmw_320i, "
              "ford_escort, vw_vanagon), whose body rolls and pitches; default: the scenario's");
  command.add("--laps", "N", arguments->run.laps, "Number of laps; default: the scenario's");
  command.add("--duration", "T", arguments->run.duration,
              "End after this time [s], while the car moves");
  command.add("--standstill", "T", arguments->run.standstill,
              "Time at standstill before the start [s]; default: 3");
  command.add_flag("--moving-start", arguments->run.ends, sim::Ends::moving,
                   "Start and end at speed: the car never stops", {excludes("--standstill")});
  command.add("--seed", "N", arguments->run.seed, "Seed of the errors and the noise; default: 1");

  const Command output = command.group("Output");
  output.add("--out", "DIR", arguments->out,
             "Folder for drive.log, camera.csv, truth.csv, car.toml, car.dbc, plant.json");
  output.add_flag("--force", arguments->existing, sim::Existing::replace,
                  "Overwrite the drive in a folder that is not empty");
  output.add_flag("--markers", arguments->markers, sim::FilmMarkers::write,
                  "Also write markers.csv: two markers on the car, filmed from above, in pixels "
                  "(for odom identify stiffness)");
  output.add(
      "--film", "FILE", arguments->film,
      "Also render a video (.avi) of the drive from above, with ArUco markers on the car, and "
      "FILE.yaml, its lens (for odom identify track); takes minutes");
  output.add_flag("--config-only", arguments->config_only,
                  "Write only car.toml, car.dbc and plant.json");
  output.add("--start-time", "T", arguments->start_time,
             "Time stamp of the start [s]; default: 1760000000, or the current time if live");
  output.add_flag("--json", arguments->json, "Print the report as JSON, with the sampled errors");
  output.add_flag("--progress", arguments->progress, "Show progress even without a terminal");

  const Command live = command.group("Live");
  live.add_flag("--live", arguments->live, "Drive in real time");
  live.add("--can", "IFACE", arguments->can,
           "Interface to send on, or - for standard output; default: -");
  live.add("--camera-socket", "PATH", arguments->camera_socket,
           "Send the camera poses to this socket of a daemon");

  const Command errors = command.group("Errors");
  errors.add_flag("--ideal", arguments->run.errors, sim::ErrorModel::ideal,
                  "No errors except those given");
  errors.add_flag("--servo", arguments->servo,
                  "Slow steering servo: sets --steering-delay 0.06, --steering-lag 0.1, "
                  "--steering-rate-limit 3, --steering-commanded 1");
  errors.add("--fix", "NAME=VALUE", arguments->fixed,
             "Set a parameter to this value instead of sampling it; the names are those of the "
             "options below, with underscores; repeatable");
  errors.add("--camera-dropout", "BEGIN:LENGTH", arguments->dropouts,
             "No camera poses from BEGIN [s] for LENGTH [s]; repeatable");
  add_parameter_options(command, *arguments);

  add_sim_experiments(command);
  command.callback([arguments, command] {
    if (!command.has_called_subcommand()) simulate(*arguments);
  });
}

}  // namespace odomd::tools
