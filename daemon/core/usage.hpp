// Explains why CLI11 rejects a command line: the first unknown argument, with the name that was
// probably meant. Also: the help text that several programs share.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace odomd::daemon {

/// Describes the models of --model, for the end of a help text.
inline constexpr std::string_view models_help =
    "Models:\n"
    "  full               dynamic bicycle with sensor errors and late samples; odomd's default\n"
    "  paper              the published extended Kalman filter\n"
    "  inertial           heading from the gyro, speed from the wheels, no filter\n"
    "  kinematic          bicycle model without slip\n"
    "  kinematic_printed  the kinematic model as printed in the paper, for comparison";

struct Mistake {
  std::string command;  ///< the command it belongs to: "odom camera"
  std::string what;
};

/// An unknown argument is reported before all other errors: it may be a misspelling of the option
/// that is missing.
[[nodiscard]] Mistake mistake_in(const CLI::App& program, const CLI::ParseError& error);

/// Rejects options and arguments with an empty value: a shell variable may be unset.
void refuse_empty_values(CLI::App& program);

/// "odom camera send": the program and the subcommands that were recognised.
[[nodiscard]] std::string called_name(const CLI::App& program);

/// 'no command "sned" (did you mean "send"?)', or with the valid names.
[[nodiscard]] std::string no_command(std::string_view given, std::span<const std::string> names);

}  // namespace odomd::daemon
