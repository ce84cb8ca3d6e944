#include "tools/completion/command_line_spec.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <sstream>
#include <string_view>
#include <utility>

namespace odomd::completion {
namespace {

constexpr std::array kinds{
    std::pair{std::string_view{"FILE"}, Values::file},
    std::pair{std::string_view{"CSV"}, Values::file},
    std::pair{std::string_view{"DBC"}, Values::file},
    std::pair{std::string_view{"LOG"}, Values::file},
    std::pair{std::string_view{"PATH"}, Values::file},
    std::pair{std::string_view{"DIR"}, Values::directory},
    std::pair{std::string_view{"IFACE"}, Values::interface},
    std::pair{std::string_view{"SRC"}, Values::source},
    std::pair{std::string_view{"NAME"}, Values::segment},
};

ValueSpec value_of(const CLI::Option& option, const std::string& type) {
  if (option.get_expected_max() == 0) return {Values::none, {}};
  const auto* const kind = std::find_if(kinds.begin(), kinds.end(),
                                        [&type](const auto& entry) { return entry.first == type; });
  if (kind != kinds.end()) return {kind->second, {}};
  if (type.find('|') == std::string::npos) return {Values::free, {}};
  ValueSpec value{Values::choice, {}};
  std::istringstream names{type};
  for (std::string name; std::getline(names, name, '|');) value.choices.push_back(name);
  return value;
}

// "PATH" of "PATH" and of "PATH:SOME CHECK".
std::string type_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  return type.substr(0, type.find(':'));
}

CommandSpec spec_of(const CLI::App& command, std::vector<std::string> path) {
  path.push_back(command.get_name());
  CommandSpec spec{path, command.get_description(), {}, {}, {}};
  for (const CLI::Option* option : command.get_options()) {
    if (!option->nonpositional()) {
      const std::string name = option->get_name();
      spec.arguments.push_back(name == "COMMAND" ? ValueSpec{Values::choice, {}}
                                                 : value_of(*option, name));
      continue;
    }
    OptionSpec one;
    for (const std::string& name : option->get_snames()) one.names.push_back('-' + name);
    for (const std::string& name : option->get_lnames()) one.names.push_back("--" + name);
    one.help = option->get_description();
    one.value = value_of(*option, type_of(*option));
    one.repeatable = option->get_expected_max() > 1 ||
                     option->get_multi_option_policy() == CLI::MultiOptionPolicy::TakeAll;
    spec.options.push_back(std::move(one));
  }
  for (const CLI::App* sub : command.get_subcommands([](const CLI::App*) { return true; }))
    spec.commands.push_back(spec_of(*sub, path));
  return spec;
}

}  // namespace

CommandSpec spec_of(const CLI::App& program) {
  CommandSpec spec = spec_of(program, {});
  // The one argument that names commands.
  for (CommandSpec& command : spec.commands)
    for (ValueSpec& argument : command.arguments)
      if (argument.values == Values::choice && argument.choices.empty())
        for (const CommandSpec& other : spec.commands)
          argument.choices.push_back(other.path.back());
  return spec;
}

std::string joined(const std::vector<std::string>& path, const std::string& between) {
  std::string text;
  for (const std::string& name : path) text += (text.empty() ? "" : between) + name;
  return text;
}

std::vector<const CommandSpec*> all_commands(const CommandSpec& command) {
  std::vector<const CommandSpec*> all{&command};
  for (const CommandSpec& sub : command.commands) {
    const auto below = all_commands(sub);
    all.insert(all.end(), below.begin(), below.end());
  }
  return all;
}

}  // namespace odomd::completion
