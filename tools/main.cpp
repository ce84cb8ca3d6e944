// odom: one command, a subcommand a file.
#include <csignal>

#include "tools/command_line.hpp"
#include "tools/commands.hpp"

int main(int argc, char** argv) {
  // A reader that has seen enough (odom ... | head) ends us without a word, even where a parent
  // left SIGPIPE ignored.
  static_cast<void>(std::signal(SIGPIPE, SIG_DFL));

  odomd::tools::CommandLine line;
  odomd::tools::describe(line.command());
  return line.run(argc, argv);
}
