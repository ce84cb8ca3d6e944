// Explains why CLI11 rejects a command line: the first unknown argument, with the name that was
// probably meant; and what the helps of several programs have in common.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace odomd::daemon {

/// What the models of --model are, for the ends of helps.
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

/// Makes an option or argument whose value is empty wrong usage: a variable of a shell may be
/// unset.
void refuse_empty_values(CLI::App& program);

/// "odom camera send": the program and the subcommands that were recognised.
[[nodiscard]] std::string called_name(const CLI::App& program);

/// 'no command "sned" (did you mean "send"?)', or with the valid names.
[[nodiscard]] std::string no_command(std::string_view given, std::span<const std::string> names);

}  // namespace odomd::daemon
