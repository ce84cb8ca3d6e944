#include "tools/commands/commands.hpp"

namespace odomd::tools {
void describe(Command odom) {
  odom.program("odom", "odom " ODOMD_VERSION);
  odom.description("Tools for odomd: watch, record, replay, simulate, evaluate and identify.");
  odom.require_subcommand();
  odom.footer(
      "Examples:\n"
      "  odom watch                       # the running daemon, live\n"
      "  odom doctor                      # problems, and how to fix them\n"
      "  odom record                      # a drive: everything that the daemon receives\n"
      "  odom replay --config car.toml --can drive.log --out pose.csv\n"
      "  odom camera send --help          # a command's options, with examples\n"
      "Exit status: 0 success, 1 failure while running, 2 wrong usage or unusable input.");
  add_bridge(odom);
  add_camera(odom);
  add_dbc(odom);
  add_doctor(odom);
  add_evaluate(odom);
  add_export(odom);
  add_fault(odom);
  add_identify(odom);
  add_import(odom);
  add_init(odom);
  add_plot(odom);
  add_pose(odom);
  add_record(odom);
  add_replay(odom);
  add_serve(odom);
  add_sim(odom);
  add_status(odom);
  add_watch(odom);
}

}  // namespace odomd::tools
