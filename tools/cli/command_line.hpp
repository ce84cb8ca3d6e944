// Runs a command line: an error becomes one line on standard error and an exit status. Some
// commands are passed on to programs in odom's folder with large dependencies of their own
// (odom-bridge, odom-fit, odom-track).
#pragma once

#include <exception>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tools/cli/command.hpp"

namespace odomd::tools {

/// Exit statuses of odom.
inline constexpr int exit_done = 0;
inline constexpr int exit_failed = 1;  ///< the work failed
inline constexpr int exit_usage = 2;   ///< wrong usage or unusable input

/// Thrown by a command that has printed its result: ends the program with this status, silently.
class Ended : public std::exception {
 public:
  explicit Ended(int status) : status_(status) {}
  [[nodiscard]] int status() const { return status_; }

 private:
  int status_;
};

class CommandLine {
 public:
  CommandLine();
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;
  ~CommandLine();

  /// The program's own command, to be described before it is run.
  [[nodiscard]] Command command() { return Command(*app_); }

  /// Parses the arguments, which runs the subcommand, and returns the exit status. Wrong usage and
  /// std::invalid_argument give exit_usage, any other exception exit_failed; each is one line on
  /// standard error, after the names of program and subcommand. Help and version go to standard
  /// output. Results that could not be written to standard output count as failed work.
  [[nodiscard]] int run(int argc, const char* const* argv) noexcept;

 private:
  std::unique_ptr<CLI::App> app_;
};

/// The command line of this process, quoted for a shell, for reports.
[[nodiscard]] std::string given_command();

/// Runs a whole program; `describe` sets up its command. A reader that closes the pipe (odom ... |
/// head) ends the program silently, even if a parent process left SIGPIPE ignored.
[[nodiscard]] int run_program(const std::function<void(Command)>& describe, int argc,
                              const char* const* argv);

/// Replaces this process with `program`. Throws std::runtime_error if that fails; if the program is
/// missing, the text is `where_missing`, which says how to install it.
[[noreturn]] void become(const std::string& program, std::vector<std::string> arguments,
                         const std::string& where_missing);

/// Likewise, passing on the options of `command`, all of which `program` must have.
[[noreturn]] void hand_over(const Command& command, const std::string& program,
                            const std::string& where_missing);

}  // namespace odomd::tools
