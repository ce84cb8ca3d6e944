// Runs a command line: an error becomes one line on standard error and an exit status. Programs in
// odom's folder with large dependencies of their own (odom-bridge, odom-fit, odom-track) are handed
// some commands.
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

/// Thrown by a command whose result is printed: ends with this exit status, without a line.
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

/// The command line of this process as a shell would take it, for reports.
[[nodiscard]] std::string given_command();

/// The whole of a program: `describe` sets up its command. A reader that closes the pipe (odom ...
/// | head) ends it silently, even if a parent process left SIGPIPE ignored.
[[nodiscard]] int run_program(const std::function<void(Command)>& describe, int argc,
                              const char* const* argv);

/// Replaces this process by that program. Throws std::runtime_error if it cannot be run; if it is
/// missing, with `where_missing`, which says how to install it.
[[noreturn]] void become(const std::string& program, std::vector<std::string> arguments,
                         const std::string& where_missing);

}  // namespace odomd::tools
