#include "tools/completion/complete.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string_view>
#include <vector>

#include "daemon/options.hpp"
#include "tools/commands/commands.hpp"

namespace odomd::completion {
namespace {

namespace fs = std::filesystem;

/// The names of values that are files.
constexpr std::array<std::string_view, 6> file_types{"FILE", "CSV", "DBC", "LOG", "PATH", "TOML"};

void offer(const std::string& word, const std::string& help = "") {
  std::cout << word << (help.empty() ? "" : "\t") << help.substr(0, help.find('\n')) << '\n';
}

/// Network devices of type 280 (ARPHRD_CAN) are CAN interfaces.
void offer_interfaces() {
  std::error_code ignored;
  for (const auto& device : fs::directory_iterator("/sys/class/net", ignored)) {
    int type = 0;
    std::ifstream(device.path() / "type") >> type;
    if (type == 280) offer(device.path().filename().string());
  }
}

void offer_segments() {
  std::error_code ignored;
  for (const auto& file : fs::directory_iterator("/dev/shm", ignored))
    if (file.is_regular_file(ignored) && file.path().extension() != ".lock")
      offer('/' + file.path().filename().string());
}

/// Offers values for a type as the help names it. NAME means a segment only with --shm.
void offer_values(const std::string& type, bool is_segment) {
  if (type == "DIR") offer(":directories");
  if (std::ranges::count(file_types, type) > 0 || type == "SRC" || is_segment) offer(":files");
  if (type == "SRC") offer("-");
  if (type == "SRC" || type == "IFACE") offer_interfaces();
  if (is_segment) offer_segments();
  if (type.find('|') == std::string::npos) return;
  std::istringstream names{type};
  for (std::string name; std::getline(names, name, '|');) offer(name);
}

std::vector<const CLI::App*> commands_of(const CLI::App& command) {
  return command.get_subcommands([](const CLI::App*) { return true; });
}

void offer_commands(const CLI::App& command) {
  for (const CLI::App* sub : commands_of(command)) offer(sub->get_name(), sub->get_description());
}

/// `before`: all words but the last.
void complete(const CLI::App& program, std::span<const std::string> before,
              const std::string& last) {
  const CLI::App* command = &program;
  for (const std::string& word : before.subspan(1)) {
    const auto below = commands_of(*command);
    const auto named = std::ranges::find(below, word, &CLI::App::get_name);
    if (named != below.end()) command = *named;
  }
  if (before.back().starts_with('-')) {
    const CLI::Option* option = command->get_option_no_throw(before.back());
    if (option != nullptr && option->get_expected_max() > 0) {
      const std::string type = option->get_type_name();  // "PATH" or "PATH:SOME CHECK"
      return offer_values(type.substr(0, type.find(':')), option->check_lname("shm"));
    }
  }
  const bool is_option = last.size() > 1 && last.starts_with('-');
  for (const CLI::Option* option : command->get_options()) {
    for (const std::string& name : option->get_snames())
      offer('-' + name, option->get_description());
    for (const std::string& name : option->get_lnames())
      offer("--" + name, option->get_description());
    if (!option->get_positional() || is_option) continue;
    offer_values(option->get_name(true), false);
  }
  offer_commands(*command);
}

}  // namespace

void complete(std::span<const std::string> words) {
  if (words.size() < 2) return;
  CLI::App app;
  daemon::Options options;
  if (words.front() == "odom") {
    tools::describe(tools::Command(app));
  } else if (words.front() == "odomd") {
    daemon::add_options(app, options);
  } else {
    return;
  }
  complete(app, words.first(words.size() - 1), words.back());
}

}  // namespace odomd::completion
