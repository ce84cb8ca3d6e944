#include "tools/commands/commands.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "daemon/core/usage.hpp"

namespace odomd::tools {
namespace {

void print_help(Command odom, const std::vector<std::string>& words) {
  const CLI::App* command = &odom.app();
  std::string name = command->get_name();
  for (const std::string& word : words) {
    const auto below = command->get_subcommands([](const CLI::App*) { return true; });
    const auto found = std::ranges::find(below, word, &CLI::App::get_name);
    if (found == below.end()) {
      std::vector<std::string> names;
      for (const CLI::App* sub : below) names.push_back(sub->get_name());
      throw std::invalid_argument(daemon::no_command(word, names));
    }
    command = *found;
    name += ' ' + word;
  }
  // Not command->help(): that describes the command that was called, not this one.
  std::cout << command->get_formatter()->make_help(command, name, CLI::AppFormatMode::Normal);
}

// odom help: prints the help of the command with the given name.
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

}  // namespace

void describe(Command odom) {
  odom.program("odom", "odom " ODOMD_VERSION);
  odom.description("Tools for odomd: watch, record, replay, simulate, evaluate and identify.");
  odom.require_subcommand();
  odom.footer(
      "Examples:\n"
      "  odom watch                       # the running daemon, live\n"
      "  odom doctor                      # what is wrong, and how to fix it\n"
      "  odom record                      # a drive, with everything that the daemon received\n"
      "  odom replay --config car.toml --can drive.log --out pose.csv\n"
      "  odom help camera send            # a command's options, with examples\n"
      "Exit status: 0 success, 1 failure while running, 2 wrong usage or unusable input.");
  add_bridge(odom);
  add_camera(odom);
  add_dbc(odom);
  add_doctor(odom);
  add_evaluate(odom);
  add_export(odom);
  add_fault(odom);
  add_help(odom);
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
