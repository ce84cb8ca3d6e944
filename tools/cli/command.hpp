// A command of the command line and its options. Hides CLI11, whose header costs five seconds of
// compiling per file: only the files that run and describe the command line include it
// (command.cpp, command_line.cpp, ../completion/).
//
// Commands and options are handles: they can be copied, and last as long as the CommandLine.
// Setters of an option return the option, so that calls can be chained.
#pragma once

#include <concepts>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace odomd::tools {

/// The types of an option's value.
template <typename T>
concept OptionValue = std::same_as<T, std::string> || std::same_as<T, std::filesystem::path> ||
    std::same_as<T, int> || std::same_as<T, std::uint64_t> || std::same_as<T, double> ||
    std::same_as<T, std::optional<int>> || std::same_as<T, std::optional<double>> ||
    std::same_as<T, std::vector<std::string>> || std::same_as<T, std::vector<double>>;

enum class Bounds { shown, in_text };

class Option {
 public:
  explicit Option(CLI::Option& option) : option_(&option) {}

  Option required() const;
  Option needs(Option other) const;
  Option excludes(Option other) const;
  Option excludes(const std::string& other) const;

  /// Numbers out of bounds are wrong usage. The help shows the bounds unless its text contains
  /// them.
  Option positive() const;
  Option not_negative() const;
  template <typename T>
  Option within(T least, T most, Bounds bounds = Bounds::shown) const;
  /// `problem` returns what is wrong with a value, or nothing if it is valid.
  Option check(const std::function<std::string(const std::string&)>& problem) const;

  /// This number of values, one argument each.
  Option values(int count) const;
  /// The values are in one argument, separated by this character.
  Option delimiter(char between) const;
  /// The value may be omitted and is then `value`.
  Option value_if_none(const std::string& value) const;
  /// May be given several times with one value each; without this a list takes all following
  /// arguments.
  Option one_each() const;
  /// As one_each(), but the help shows a single value.
  Option repeatable() const;

  [[nodiscard]] bool is_given() const;

 private:
  friend class Command;
  CLI::Option* option_;
};

class Command {
 public:
  explicit Command(CLI::App& app) : app_(&app) {}

  /// The same command, whose options are listed under this heading in the help; empty: none.
  [[nodiscard]] Command group(const std::string& heading) const;

  Command rename(const std::string& name) const;
  Command description(const std::string& sentence) const;
  /// The text at the end of the help.
  Command footer(const std::string& text) const;
  Command help_flag() const;
  Command version_flag(const std::string& version) const;

  [[nodiscard]] Command add_subcommand(const std::string& name,
                                       const std::string& sentence = "") const;
  /// One of its subcommands is required.
  Command require_subcommand() const;
  /// Whether one of its subcommands was called.
  [[nodiscard]] bool has_called_subcommand() const;
  [[nodiscard]] std::vector<Command> subcommands() const;

  /// An option (--name) or an argument (NAME), which sets `value`; that one must last until the
  /// command line has been parsed. `type` is the name of the value in the help: FILE, S, a|b|c. It
  /// also selects the shell completion.
  template <OptionValue T>
  Option add(const std::string& name, const std::string& type, T& value,
             const std::string& help) const;
  Option add_flag(const std::string& name, bool& value, const std::string& help) const;
  /// Calls `chosen` with the index of the name that was given.
  Option add_choice(const std::string& name, const std::vector<std::string>& choices,
                    const std::function<void(std::size_t)>& chosen, const std::string& help) const;

  /// An option for a file of measurements. Add it before the options that the file may give.
  /// The file is a JSON object: names are those of options, with underscores; values are numbers,
  /// texts, or lists of them. The command line has precedence, also by an option that excludes one
  /// of the file. One file serves sibling commands: their options are passed over, other names are
  /// errors.
  Option add_measurements(const std::string& name, const std::string& type,
                          const std::string& help) const;

  /// All options so far except the help flag.
  [[nodiscard]] std::vector<Option> options() const;

  [[nodiscard]] std::string name() const;
  /// The help that `name --help` prints.
  [[nodiscard]] std::string help(const std::string& name) const;
  /// The given options as arguments for another program with the same options.
  [[nodiscard]] std::vector<std::string> given() const;

  /// Called once the command line has been parsed.
  void callback(const std::function<void()>& action) const;

  /// CLI11's own.
  [[nodiscard]] CLI::App& app() const { return *app_; }

 private:
  Option grouped(CLI::Option& option) const;

  CLI::App* app_;
  std::string heading_;
};

/// For an action that finds a required option missing: reports wrong usage.
[[noreturn]] void require(const std::string& what);

template <typename T>
using Choices = std::vector<std::pair<std::string, T>>;

/// Adds the option `flag`, which sets `value` to what the given name stands for. Help shows the
/// names; another one is wrong usage.
template <typename T>
Option add_choice(Command command, const std::string& flag, T& value, const Choices<T>& choices,
                  const std::string& help) {
  std::vector<std::string> names;
  for (const auto& choice : choices) names.push_back(choice.first);
  return command.add_choice(
      flag, names, [&value, choices](std::size_t index) { value = choices[index].second; }, help);
}

}  // namespace odomd::tools
