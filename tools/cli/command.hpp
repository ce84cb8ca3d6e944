// A command of the command line and its options, one row each: name, type, value, help, rules.
// Hides CLI11, whose header costs four seconds of compiling per file: only the files that run and
// describe the command line include it (command.cpp, command_line.cpp, ../commands/commands.cpp,
// ../completion/).
//
// Commands are handles: they can be copied, and last as long as the CommandLine.
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

/// A constraint on an option, beyond its type.
using Rule = std::function<void(CLI::Option&)>;
using Rules = std::vector<Rule>;

[[nodiscard]] Rule required();
/// `other` is an option that was added before: "--log", "CSV".
[[nodiscard]] Rule needs(const std::string& other);
[[nodiscard]] Rule excludes(const std::string& other);

/// Numbers out of bounds are wrong usage. The help shows the bounds unless its text contains them.
[[nodiscard]] Rule positive();
[[nodiscard]] Rule not_negative();
enum class Bounds { shown, in_text };
template <typename T>
[[nodiscard]] Rule within(T least, T most, Bounds bounds = Bounds::shown);
/// `problem` returns what is wrong with a value, or nothing if it is valid.
[[nodiscard]] Rule checked(const std::function<std::string(const std::string&)>& problem);

/// This number of values, one argument each.
[[nodiscard]] Rule values(int count);
/// The values are in one argument, separated by this character.
[[nodiscard]] Rule delimiter(char between);
/// The value may be omitted and is then `value`.
[[nodiscard]] Rule value_if_none(const std::string& value);
/// May be given several times with one value each; without this a list takes all following
/// arguments.
[[nodiscard]] Rule one_each();
/// Like one_each(), but the help shows a single value.
[[nodiscard]] Rule repeatable();

template <typename T>
using Choices = std::vector<std::pair<std::string, T>>;

class Command {
 public:
  explicit Command(CLI::App& app) : app_(&app) {}

  /// A copy of this command whose options the help lists under `heading`; empty: under no heading.
  [[nodiscard]] Command group(const std::string& heading) const;

  /// Names the program and adds the options --version and --help.
  void program(const std::string& name, const std::string& version) const;
  void description(const std::string& sentence) const;
  /// The text at the end of the help.
  void footer(const std::string& text) const;

  [[nodiscard]] Command add_subcommand(const std::string& name,
                                       const std::string& sentence = "") const;
  void require_subcommand() const;
  [[nodiscard]] bool has_called_subcommand() const;

  /// An option (--name) or an argument (NAME). It sets `value`, which must exist until the command
  /// line has been parsed. `type` is the name of the value in the help: FILE, S, a|b|c. It also
  /// selects the shell completion.
  template <OptionValue T>
  void add(const std::string& name, const std::string& type, T& value, const std::string& help,
           const Rules& rules = {}) const;
  /// An option without a value, which sets `value` to `given`.
  template <typename T>
  void add_flag(const std::string& name, T& value, T given, const std::string& help,
                const Rules& rules = {}) const {
    add_flag(
        name, [&value, given] { value = given; }, help, rules);
  }
  void add_flag(const std::string& name, bool& value, const std::string& help,
                const Rules& rules = {}) const {
    add_flag(name, value, true, help, rules);
  }
  /// An option that sets `value` to the value with the given name. The help shows the names.
  template <typename T>
  void add_choice(const std::string& name, T& value,
                  const Choices<std::type_identity_t<T>>& choices, const std::string& help,
                  const Rules& rules = {}) const {
    std::vector<std::string> names;
    for (const auto& choice : choices) names.push_back(choice.first);
    const auto choose = [&value, choices](std::size_t index) { value = choices[index].second; };
    add_choice(name, names, choose, help, rules);
  }

  /// An option for a file of measurements. Add it before the options that the file may give. The
  /// file is a JSON object: names are those of options, with underscores; values are numbers,
  /// texts, or lists of them. The command line has precedence: an option on it cancels the same
  /// option in the file, and the options that it excludes. One file serves sibling commands:
  /// options of siblings are skipped, unknown names are errors.
  void add_measurements(const std::string& name, const std::string& type,
                        const std::string& help) const;

  /// Further rules for an option that was added before.
  void add_rules(const std::string& name, const Rules& rules) const;

  /// Called once the command line has been parsed.
  void callback(const std::function<void()>& action) const;

  /// The underlying CLI11 object.
  [[nodiscard]] CLI::App& app() const { return *app_; }

 private:
  void add_flag(const std::string& name, const std::function<void()>& set, const std::string& help,
                const Rules& rules) const;
  void add_choice(const std::string& name, const std::vector<std::string>& names,
                  const std::function<void(std::size_t)>& choose, const std::string& help,
                  const Rules& rules) const;
  void complete(CLI::Option& option, const Rules& rules) const;

  CLI::App* app_;
  std::string heading_;
};

/// Reports a missing option as wrong usage, for an action that requires it.
[[noreturn]] void require(const std::string& what);

// The options with which a command finds the daemon, the same for all commands.

/// Which segment to use without --shm: the library's default; or, for commands with --socket, the
/// segment of the daemon at that socket if one is given.
enum class SegmentElse { default_names, of_socket };

/// --shm: the segment in which the daemon publishes.
void add_segment_option(Command command, std::string& name,
                        SegmentElse otherwise = SegmentElse::default_names,
                        const Rules& rules = {});

/// --socket. `purpose` of the socket: "status", "record", "camera".
void add_socket_option(Command command, std::string& path, const std::string& purpose,
                       const Rules& rules = {});

/// --wait [s].
void add_wait_option(Command command, double& seconds);

}  // namespace odomd::tools
