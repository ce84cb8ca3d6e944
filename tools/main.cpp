// odom: one command, with one file per subcommand.
#include <string_view>
#include <vector>

#include "tools/cli/command_line.hpp"
#include "tools/commands/commands.hpp"
#include "tools/completion/complete.hpp"

int main(int argc, char** argv) {
  if (argc > 3 && std::string_view{argv[1]} == "complete") {
    odomd::completion::complete(std::vector<std::string>(argv + 2, argv + argc));
    return 0;
  }
  return odomd::tools::run_program(odomd::tools::describe, argc, argv);
}
