// odom help: the help of a command, by its name.
#include <algorithm>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "daemon/core/usage.hpp"
#include "tools/commands/commands.hpp"

namespace odomd::tools {
namespace {

void print_help(Command odom, const std::vector<std::string>& words) {
  Command command = odom;
  std::string before;
  for (const std::string& word : words) {
    const std::vector<Command> below = command.subcommands();
    const auto found =
        std::ranges::find_if(below, [&word](const Command& sub) { return sub.name() == word; });
    if (found == below.end()) {
      std::vector<std::string> names;
      names.reserve(below.size());
      for (const Command& sub : below) names.push_back(sub.name());
      throw std::invalid_argument(daemon::no_command(word, names));
    }
    before += (before.empty() ? "" : " ") + command.name();
    command = *found;
  }
  std::cout << command.help(before + (before.empty() ? "" : " ") + command.name());
}

}  // namespace

void add_help(Command odom) {
  auto words = std::make_shared<std::vector<std::string>>();
  Command command = odom.add_subcommand("help", "Print the help of a command");
  command.add("COMMAND", "", *words, "The command; none: odom itself");
  command.footer(
      "Examples:\n"
      "  odom help\n"
      "  odom help replay\n"
      "  odom help camera send");
  command.callback([odom, words] { print_help(odom, *words); });
}

}  // namespace odomd::tools
