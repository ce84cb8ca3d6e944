// odom: one command, a subcommand a file.
#include "tools/cli/command_line.hpp"
#include "tools/commands/commands.hpp"

int main(int argc, char** argv) {
  return odomd::tools::run_program(odomd::tools::describe, argc, argv);
}
