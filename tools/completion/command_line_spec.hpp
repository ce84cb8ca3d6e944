// A command line as data: what CLI11 knows of a program, for writing completions.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace odomd::completion {

/// The kinds of values.
enum class Values {
  none,    ///< a flag takes no value
  free,    ///< a number, a title: not completed
  choice,  ///< one of some names
  file,    ///< also sockets
  directory,
  interface,  ///< of the CAN bus
  source,     ///< an interface, a log, or -
  segment     ///< of shared memory, or a path
};

struct ValueSpec {
  Values values = Values::none;
  std::vector<std::string> choices;
};

struct OptionSpec {
  std::vector<std::string> names;  ///< with their dashes
  std::string help;
  ValueSpec value;
  bool repeatable = false;
};

struct CommandSpec {
  std::vector<std::string> path;  ///< "odom", "camera", "send"
  std::string help;
  std::vector<OptionSpec> options;
  std::vector<ValueSpec> arguments;  ///< positional arguments
  std::vector<CommandSpec> commands;
};

/// The options of a program and all its subcommands. The name of a value's type selects its
/// completion: FILE, CSV, DBC, LOG, PATH; DIR; IFACE; SRC; NAME (a segment); a|b|c. Other types are
/// not completed.
[[nodiscard]] CommandSpec spec_of(const CLI::App& program);

/// The names of a command path joined: "odom camera send".
[[nodiscard]] std::string joined(const std::vector<std::string>& path, const std::string& between);

/// A command and all below it, the outermost first.
[[nodiscard]] std::vector<const CommandSpec*> all_commands(const CommandSpec& command);

}  // namespace odomd::completion
