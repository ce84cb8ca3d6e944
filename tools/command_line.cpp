#include "tools/command_line.hpp"

#include <CLI/CLI.hpp>
#include <csignal>
#include <exception>
#include <iostream>
#include <stdexcept>
#include <string>
#include <string_view>

#include "tools/files.hpp"

namespace odomd::tools {
namespace {

// "odom camera send": the program and the subcommands that were recognised.
std::string called_name(const CLI::App& app) {
  std::string name = app.get_name();
  for (const CLI::App* sub : app.get_subcommands()) {
    name += ' ' + called_name(*sub);
  }
  return name;
}

int report(const CLI::App& odom, std::string_view text, int status) {
  std::string line = called_name(odom) + ": ";
  for (const char c : text) {
    line += c == '\n' ? ' ' : c;  // one line, whatever was thrown
  }
  std::cout.flush();
  std::cerr << line << '\n';
  return status;
}

// The names of the commands below `app`, for the one who mistyped one.
std::string command_names(const CLI::App& app) {
  std::string names;
  for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; })) {
    names += (names.empty() ? "" : ", ") + sub->get_name();
  }
  return names;
}

const CLI::App& innermost(const CLI::App& app) {
  const auto parsed = app.get_subcommands();
  return parsed.empty() ? app : innermost(*parsed.front());
}

int report_usage(const CLI::App& odom, const CLI::ParseError& error) {
  const CLI::App& command = innermost(odom);
  const std::string help = "; see " + called_name(odom) + " --help";
  const std::string names = command_names(command);
  const bool names_no_command = dynamic_cast<const CLI::RequiredError*>(&error) != nullptr ||
                                dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr;
  if (!names.empty() && names_no_command) {
    const auto rest = command.remaining();
    const std::string what =
        rest.empty() ? "no command given" : "no command \"" + rest.front() + "\"";
    return report(odom, what + "; there are: " + names + help, exit_usage);
  }
  return report(odom, error.what() + help, exit_usage);
}

}  // namespace

CommandLine::CommandLine() : app_(std::make_unique<CLI::App>()) {}

CommandLine::~CommandLine() = default;

int CommandLine::run(int argc, const char* const* argv) noexcept {
  CLI::App& odom = *app_;
  try {
    try {
      odom.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) {
        odom.exit(error);  // help or version, to standard output
      } else {
        return report_usage(odom, error);
      }
    }
    if (!std::cout.flush())
      return report(odom, "standard output: " + why_unwritten(std::cout), exit_failed);
    return exit_done;
  } catch (const std::invalid_argument& error) {
    return report(odom, error.what(), exit_usage);
  } catch (const std::exception& error) {
    return report(odom, error.what(), exit_failed);
  }
}

int run_program(const std::function<void(Command)>& describe, int argc, const char* const* argv) {
  static_cast<void>(std::signal(SIGPIPE, SIG_DFL));
  CommandLine line;
  describe(line.command());
  return line.run(argc, argv);
}

}  // namespace odomd::tools
