// A command of the command line and its options. All that the commands know of CLI11, whose header
// costs every file that includes it five seconds of compiling: it is included where the command
// line is run and told of (command.cpp, command_line.cpp, ../completion/), and nowhere else.
//
// Commands and options are handles: they are copied, and last as long as the CommandLine. What is
// set on an option returns the option, for the next thing to be set.
#pragma once

#include <concepts>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace odomd::tools {

/// What an option's value can be.
template <typename T>
concept OptionValue = std::same_as<T, std::string> || std::same_as<T, std::filesystem::path> ||
    std::same_as<T, int> || std::same_as<T, std::uint64_t> || std::same_as<T, double> ||
    std::same_as<T, std::optional<int>> || std::same_as<T, std::optional<double>> ||
    std::same_as<T, std::vector<std::string>> || std::same_as<T, std::vector<double>>;

enum class Bounds { shown, told };

class Option {
 public:
  explicit Option(CLI::Option& option) : option_(&option) {}

  /// What help shows in place of a value: FILE, S, a|b|c. The shells' completions go by it.
  Option type_name(const std::string& name) const;
  /// Under which heading help tells of it.
  Option group(const std::string& heading) const;

  Option required() const;
  Option needs(Option other) const;
  Option excludes(Option other) const;
  Option excludes(const std::string& other) const;

  /// Numbers out of bounds are wrong usage; where its sentence has no word of them, help shows
  /// them.
  Option positive() const;
  Option not_negative() const;
  template <typename T>
  Option within(T least, T most, Bounds bounds = Bounds::shown) const;
  /// `problem` returns what is wrong with a value; nothing: it is taken.
  Option check(const std::function<std::string(const std::string&)>& problem) const;

  /// So many values, one argument each.
  Option values(int count) const;
  /// Its values stand in one argument, with this between them.
  Option delimiter(char between) const;
  /// The value may be left out, and is then `value`.
  Option value_if_none(const std::string& value) const;
  /// May stand several times with a value each; without it a list takes all arguments that follow.
  Option one_each() const;
  /// As one_each(); help shows a single value.
  Option repeatable() const;

  [[nodiscard]] bool is_given() const;

 private:
  friend class Command;
  CLI::Option* option_;
};

class Command {
 public:
  explicit Command(CLI::App& app) : app_(&app) {}

  Command rename(const std::string& name) const;
  Command description(const std::string& sentence) const;
  /// What help ends with.
  Command footer(const std::string& text) const;
  Command help_flag() const;
  Command version_flag(const std::string& version) const;

  [[nodiscard]] Command add_subcommand(const std::string& name,
                                       const std::string& sentence = "") const;
  /// It is nothing without one of its subcommands.
  Command require_subcommand() const;
  /// Whether one of them was called.
  [[nodiscard]] bool has_called_subcommand() const;
  [[nodiscard]] std::vector<Command> subcommands() const;

  /// An option (--name) or an argument (NAME), which sets `value`; that one must last until the
  /// command line has been parsed.
  template <OptionValue T>
  Option add_option(const std::string& name, T& value, const std::string& help) const;
  Option add_flag(const std::string& name, bool& value, const std::string& help) const;
  /// Calls `chosen` with the index of the name that was given.
  Option add_choice(const std::string& name, const std::vector<std::string>& choices,
                    const std::function<void(std::size_t)>& chosen, const std::string& help) const;

  /// All options so far but for the help flag.
  [[nodiscard]] std::vector<Option> options() const;

  [[nodiscard]] std::string name() const;
  /// The help that `name --help` prints.
  [[nodiscard]] std::string help(const std::string& name) const;
  /// What was given, as arguments of another program with the same options.
  [[nodiscard]] std::vector<std::string> given() const;

  /// What the command does, called once its command line has been parsed.
  void callback(const std::function<void()>& action) const;

  /// CLI11's own.
  [[nodiscard]] CLI::App& app() const { return *app_; }

 private:
  CLI::App* app_;
};

/// For an action that finds that something should have been given: wrong usage.
[[noreturn]] void require(const std::string& what);

}  // namespace odomd::tools
