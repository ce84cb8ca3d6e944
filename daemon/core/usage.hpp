// What is wrong with a command line that CLI11 refuses: the first argument that it does not know,
// with the name that was likely meant.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace odomd::daemon {

struct Mistake {
  std::string command;  ///< whose it is: "odom camera"
  std::string what;
};

/// An argument that is not known comes before whatever else is wrong: it may be the very option
/// that is missing.
[[nodiscard]] Mistake mistake_in(const CLI::App& program, const CLI::ParseError& error);

/// "odom camera send": the program and the subcommands that were recognised.
[[nodiscard]] std::string called_name(const CLI::App& program);

/// 'no command "sned" (did you mean "send"?)', else with the names that there are.
[[nodiscard]] std::string no_command(std::string_view given, std::span<const std::string> names);

}  // namespace odomd::daemon
