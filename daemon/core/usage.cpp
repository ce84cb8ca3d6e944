#include "daemon/core/usage.hpp"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include "base/nearest_name.hpp"
#include "base/printable.hpp"

namespace odomd::daemon {
namespace {

const CLI::App* called_below(const CLI::App& command) {
  const auto called = command.get_subcommands();
  return called.empty() ? nullptr : called.front();
}

std::vector<std::string> names_below(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::App* sub : command.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(sub->get_name());
  return names;
}

std::string unknown_option(const CLI::App& command, std::string_view argument) {
  const std::string_view given = argument.substr(0, argument.find('='));  // "--laps" of "--laps=3"
  const std::string what = "unknown option " + quoted(given);
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back(name);
  const std::size_t dashes = std::min(given.find_first_not_of('-'), given.size());
  const std::string_view likely = likely_name(given.substr(dashes), names);
  if (!likely.empty()) return fmt::format("{} (did you mean \"--{}\"?)", what, likely);
  return names_below(command).empty() ? what
                                      : what + ": options go after the command that has them";
}

/// What is wrong with the first unknown argument of the command line, if there is one. The
/// arguments after a subcommand belong to the subcommand.
std::optional<Mistake> unknown_argument(const CLI::App& program) {
  std::string called;
  for (const CLI::App* command = &program; command != nullptr; command = called_below(*command)) {
    called += (called.empty() ? "" : " ") + command->get_name();
    for (const std::string& argument : command->remaining()) {
      if (argument == "--") continue;
      if (argument.size() > 1 && argument.front() == '-')
        return Mistake{called, unknown_option(*command, argument)};
      const std::vector<std::string> names = names_below(*command);
      return Mistake{called, names.empty() || called_below(*command) != nullptr
                                 ? "unexpected argument " + odomd::quoted(argument)
                                 : no_command(argument, names)};
    }
  }
  return std::nullopt;
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
  if (auto unknown = unknown_argument(program)) return *std::move(unknown);
  const CLI::App& command = innermost(program);
  if (command.get_require_subcommand_min() > 0 &&
      dynamic_cast<const CLI::RequiredError*>(&error) != nullptr)
    return {called_name(program),
            fmt::format("no command given; there are: {}", fmt::join(names_below(command), ", "))};
  if (dynamic_cast<const CLI::ConversionError*>(&error) != nullptr)
    return {called_name(program),
            fmt::format("{}: write a number without a unit, in the unit of the help; whole for a "
                        "count, otherwise with a decimal point",
                        error.what())};
  return {called_name(program), error.what()};
}

}  // namespace odomd::daemon
