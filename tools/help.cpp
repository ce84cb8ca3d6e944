// odom help: the help of a command, by its name.
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "tools/commands.hpp"

namespace odomd::tools {
namespace {

void print_help(const CLI::App& odom, const std::vector<std::string>& words) {
  const CLI::App* command = &odom;
  std::string before;
  for (const std::string& word : words) {
    const CLI::App* found = nullptr;
    std::string names;
    for (const CLI::App* sub : command->get_subcommands([](const CLI::App*) { return true; })) {
      if (sub->get_name() == word) found = sub;
      names += (names.empty() ? "" : ", ") + sub->get_name();
    }
    if (found == nullptr) {
      throw std::invalid_argument("no command \"" + word + "\"" +
                                  (names.empty() ? "" : "; there are: " + names));
    }
    before += (before.empty() ? "" : " ") + command->get_name();
    command = found;
  }
  // Not command->help(), which would tell of the command that was called: this one.
  const std::string name = before + (before.empty() ? "" : " ") + command->get_name();
  std::cout << command->get_formatter()->make_help(command, name, CLI::AppFormatMode::Normal);
}

}  // namespace

void add_help(CLI::App& odom) {
  auto words = std::make_shared<std::vector<std::string>>();
  auto* command = odom.add_subcommand("help", "Print the help of a command");
  command->add_option("COMMAND", *words, "The command; none: odom itself")->type_name("");
  command->footer(
      "Examples:\n"
      "  odom help\n"
      "  odom help replay\n"
      "  odom help camera send");
  command->callback([&odom, words] { print_help(odom, *words); });
}

}  // namespace odomd::tools
