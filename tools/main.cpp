// odom: one command, a subcommand a file.
#include <csignal>

#include "tools/command_line.hpp"
#include "tools/commands.hpp"

int main(int argc, char** argv) {
  // A reader that has seen enough (odom ... | head) ends us without a word, even where a parent
  // left SIGPIPE ignored.
  static_cast<void>(std::signal(SIGPIPE, SIG_DFL));

  CLI::App odom{"Odometry by hand: replay, simulate, evaluate and watch.", "odom"};
  odom.set_version_flag("--version", "odom " ODOMD_VERSION);
  odom.require_subcommand(1);
  odom.footer(
      "odom COMMAND --help explains a command, with examples.\n"
      "Exit status: 0 done, 1 the work failed, 2 wrong usage or unusable input.");
  odomd::tools::add_camera(odom);
  odomd::tools::add_dbc(odom);
  odomd::tools::add_evaluate(odom);
  odomd::tools::add_pose(odom);
  odomd::tools::add_replay(odom);
  odomd::tools::add_sim(odom);
  odomd::tools::add_status(odom);
  odomd::tools::add_watch(odom);

  return odomd::tools::run(odom, argc, argv);
}
