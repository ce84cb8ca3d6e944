#include "tools/commands.hpp"

namespace odomd::tools {

void describe(CLI::App& odom) {
  odom.name("odom");
  odom.description("Odometry by hand: watch, record, replay, simulate, evaluate and identify.");
  odom.set_version_flag("--version", "odom " ODOMD_VERSION, "Print the version and exit");
  odom.set_help_flag("-h,--help", "Print this help and exit");
  odom.require_subcommand(1);
  odom.footer(
      "Examples:\n"
      "  odom watch                       the running daemon, live\n"
      "  odom record                      a drive, with all that the daemon took in\n"
      "  odom replay --config car.toml --can drive.log --out pose.csv\n"
      "  odom help camera send            what a command takes, with examples\n"
      "Exit status: 0 done, 1 the work failed, 2 wrong usage or unusable input.");
  add_bridge(odom);
  add_camera(odom);
  add_dbc(odom);
  add_evaluate(odom);
  add_export(odom);
  add_help(odom);
  add_identify(odom);
  add_plot(odom);
  add_pose(odom);
  add_record(odom);
  add_replay(odom);
  add_sim(odom);
  add_status(odom);
  add_tune(odom);
  add_watch(odom);
}

}  // namespace odomd::tools
