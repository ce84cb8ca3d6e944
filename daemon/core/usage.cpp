#include "daemon/core/usage.hpp"

#include <algorithm>
#include <optional>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include "base/nearest_name.hpp"
#include "base/printable.hpp"

namespace odomd::daemon {
namespace {

struct Stray {
  const CLI::App* command;  ///< the command that does not know it
  std::string called;       ///< "odom camera"
  std::string argument;
};

const CLI::App* called_below(const CLI::App& command) {
  const auto called = command.get_subcommands();
  return called.empty() ? nullptr : called.front();
}

std::vector<const CLI::App*> all_below(const CLI::App& command) {
  return command.get_subcommands([](const CLI::App*) { return true; });
}

std::vector<std::string> names_below(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::App* sub : all_below(command)) names.push_back(sub->get_name());
  return names;
}

// The first unknown argument of the command line; the arguments after a subcommand belong to it.
std::optional<Stray> first_stray(const CLI::App& program) {
  std::string called;
  for (const CLI::App* command = &program; command != nullptr; command = called_below(*command)) {
    called += (called.empty() ? "" : " ") + command->get_name();
    for (const std::string& argument : command->remaining())
      if (argument != "--") return Stray{command, called, argument};
  }
  return std::nullopt;
}

bool is_option(std::string_view argument) {
  return argument.size() > 1 && argument.front() == '-';
}

// "--laps" of "--laps=3".
std::string_view without_value(std::string_view argument) {
  return argument.substr(0, argument.find('='));
}

std::string_view without_dashes(std::string_view option) {
  return option.substr(std::min(option.find_first_not_of('-'), option.size()));
}

/// The option of a command that was probably meant, without its dashes; may be empty.
std::string likely_option(const CLI::App& command, std::string_view given) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back(name);
  return std::string(likely_name(without_dashes(given), names));
}

/// Appends the options of all subcommands of `command` that may be meant: "odom sim --laps".
void add_options_below(const CLI::App& command, const std::string& called, std::string_view given,
                       std::vector<std::string>& found) {
  for (const CLI::App* sub : all_below(command)) {
    const std::string name = fmt::format("{} {}", called, sub->get_name());
    const std::string option = likely_option(*sub, given);
    if (!option.empty()) found.push_back(fmt::format("{} --{}", name, option));
    add_options_below(*sub, name, given, found);
  }
}

std::string unknown_option(const Stray& stray) {
  const std::string_view given = without_value(stray.argument);
  const std::string what = "unknown option " + quoted(given);
  const std::string own = likely_option(*stray.command, given);
  if (!own.empty()) return fmt::format("{} (did you mean \"--{}\"?)", what, own);
  std::vector<std::string> elsewhere;
  if (const CLI::App* sub = called_below(*stray.command)) {
    const std::string option = likely_option(*sub, given);
    if (!option.empty())
      elsewhere.push_back(fmt::format("{} {} --{}", stray.called, sub->get_name(), option));
  } else {
    add_options_below(*stray.command, stray.called, given, elsewhere);
  }
  if (elsewhere.size() == 1) return fmt::format("{} (did you mean \"{}\"?)", what, elsewhere[0]);
  return elsewhere.empty() ? what : what + ": options go after the command that has them";
}

std::string unknown(const Stray& stray) {
  if (is_option(stray.argument)) return unknown_option(stray);
  const std::vector<std::string> names = names_below(*stray.command);
  if (!names.empty() && called_below(*stray.command) == nullptr)
    return no_command(stray.argument, names);
  return "unexpected argument " + odomd::quoted(stray.argument);
}

const CLI::App& innermost(const CLI::App& command) {
  const CLI::App* below = called_below(command);
  return below == nullptr ? command : innermost(*below);
}

}  // namespace

std::string called_name(const CLI::App& program) {
  const CLI::App* below = called_below(program);
  return program.get_name() + (below == nullptr ? "" : ' ' + called_name(*below));
}

std::string no_command(std::string_view given, std::span<const std::string> names) {
  std::string what = "no command " + quoted(given);
  const std::string_view meant = likely_name(given, names);
  if (!meant.empty()) return what + fmt::format(" (did you mean \"{}\"?)", meant);
  return names.empty() ? what : what + fmt::format("; there are: {}", fmt::join(names, ", "));
}

void refuse_empty_values(CLI::App& program) {
  for (CLI::Option* option : program.get_options())
    if (option->get_items_expected_max() > 0)
      option->check([](const std::string& value) {
        return value.empty() ? "is empty; give a value, or leave it out" : "";
      });
  for (CLI::App* command : program.get_subcommands([](CLI::App*) { return true; }))
    refuse_empty_values(*command);
}

Mistake mistake_in(const CLI::App& program, const CLI::ParseError& error) {
  if (const auto stray = first_stray(program)) return {stray->called, unknown(*stray)};
  const CLI::App& command = innermost(program);
  if (command.get_require_subcommand_min() > 0 &&
      dynamic_cast<const CLI::RequiredError*>(&error) != nullptr)
    return {called_name(program),
            fmt::format("no command given; there are: {}", fmt::join(names_below(command), ", "))};
  if (dynamic_cast<const CLI::ConversionError*>(&error) != nullptr)
    return {called_name(program),
            fmt::format("{}: write a number with a decimal point and without a unit, in the unit "
                        "of the help",
                        error.what())};
  return {called_name(program), error.what()};
}

}  // namespace odomd::daemon
