// odom init: creates a configuration from a database and a drive.
#include "tools/init/init.hpp"
#include "tools/commands/commands.hpp"
#include "tools/replay/log_options.hpp"

namespace odomd::tools {
namespace {

struct InitArguments {
  InitOptions init;
  bool json = false;
};

void run(const InitArguments& options) {
  const InitResult result = init(options.init);
  for (const auto& warning : result.warnings) warn("init", text_of(warning));
  std::cout << (options.json ? json_text(as_json(result.draft), 2) + '\n' : as_text(result.draft));
  const std::string out = options.init.out.string();
  if (!result.wrote_database.empty())
    say(fmt::format("odom init: wrote {}, which {} names", result.wrote_database, out));
  say(fmt::format(
      "odom init: wrote {0}. Read its lines marked UNSURE, then check it: odomd --config "
      "{0} --check",
      out));
  if (!options.init.can.empty())
    say(fmt::format("odom init: try it: odom replay --config {} --can {} --out pose.csv", out,
                    options.init.can.front()));
}

}  // namespace

void add_init(Command odom) {
  const auto options = std::make_shared<InitArguments>();
  Command command =
      odom.add_subcommand("init", "Write a configuration from a CAN database and a drive");
  command.add("--dbc", "DBC", options->init.databases,
              "Database (DBC); repeatable. Default: odomd.dbc, if the log's identifiers match it",
              {one_each()});
  constexpr int last_vesc = 254;  // 255 addresses all VESCs
  command.add("--vesc", "ID", options->init.vesc,
              "ID of the VESC whose CAN status frames give the speed. Their database is written "
              "beside FILE as vesc-ID.dbc",
              {within(0, last_vesc)});
  command.add("--can", "SRC", options->init.can,
              "Log of candump -L in which the car drives turns, or an interface; logs: repeatable. "
              "Without it, the proposal rests on the database alone",
              {one_each()});
  command.add("--for", "S", options->init.listen_s,
              "Time to listen to an interface [s]; default: 20", {within(1.0, 600.0)});
  command.add("--out", "FILE", options->init.out, "Configuration to write; default: car.toml");
  command.add_flag("--force", options->init.overwrite, Overwrite::replace,
                   "Replace an existing file");
  command.add_flag("--json", options->json, "Print the proposal as JSON");
  const Command car = command.group(
      "The car; mass and wheelbase are required, the others only if a proposed signal needs them");
  CarTexts& texts = options->init.car;
  car.add("--mass", "KG", texts.mass, "Mass of the car as it drives; units: kg, g");
  car.add("--wheelbase", "M", texts.wheelbase,
          "Distance from front to rear axle; units: m, cm, mm");
  car.add("--front-axle", "M", texts.front_axle,
          "Distance from the centre of gravity to the front axle; default: half the wheelbase");
  car.add("--track", "M", texts.track,
          "Distance from left to right wheels; default: determined from wheels and gyro, if both "
          "exist");
  car.add("--wheel-radius", "M", texts.wheel_radius,
          "Rolling radius of the wheels, for wheels and motors that report turns");
  car.add("--steering-ratio", "R", texts.steering_ratio,
          "Steering-wheel angle / front-wheel angle; default: determined from the turns");
  car.add("--full-lock", "RAD", texts.full_lock,
          "Front-wheel angle at a steering command of 1; default: determined from the turns");
  car.add("--gear-ratio", "R", texts.gear_ratio, "Motor turns per wheel turn");
  car.add("--pole-pairs", "N", texts.pole_pairs,
          "Pole pairs of a motor that reports electrical turns");
  add_strict(command, options->init.damage);
  command.footer(
      "Examples:\n"
      "  odom init --dbc car.dbc --can drive.log\n"
      "  odom init --dbc car.dbc --can can0 --for 30         # drive turns meanwhile\n"
      "  odom init --can drive.log --mass 2.98 --wheelbase 260mm --track 160mm\n"
      "  odom init --vesc 23 --pole-pairs 2 --wheel-radius 51mm --gear-ratio 11.8 --dbc imu.dbc\n"
      "  odom init --dbc car.dbc --mass 1700 --wheelbase 2.66 --track 1.56 --json\n"
      "Drive for a minute: stand still, turn left and right, brake. The file states where each\n"
      "value comes from; lines marked UNSURE are guesses. It is written only if odomd can load\n"
      "it. Exit status: 0 written, 2 unusable input.");
  command.callback([options] { run(*options); });
}

}  // namespace odomd::tools
