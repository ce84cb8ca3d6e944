// odom identify fit: hands over to the program odom-fit, which alone is linked with Ceres.
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "tools/identify/fit_options.hpp"
#include "tools/identify/methods.hpp"

namespace odomd::tools {
namespace {

// What was given, as arguments of the same command line.
std::vector<std::string> arguments_of(const CLI::App& command) {
  std::vector<std::string> result;
  for (const CLI::Option* option : command.get_options()) {
    if (option->count() == 0) continue;
    const std::string name = option->get_name();
    if (option->get_items_expected_max() == 0) {
      result.push_back(name);
    } else if (option->get_items_expected_max() == 2) {
      result.push_back(name);
      result.insert(result.end(), option->results().begin(), option->results().end());
    } else {
      for (const std::string& value : option->results()) {
        result.push_back(name);
        result.back() += "=" + value;
      }
    }
  }
  return result;
}

// Never comes back.
void become_odom_fit(const CLI::App& command, const FitOptions& options) {
  check(options);
  const auto program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "odom-fit";
  std::vector<std::string> arguments = arguments_of(command);
  arguments.insert(arguments.begin(), program.string());
  std::vector<char*> argv;
  argv.reserve(arguments.size() + 1);
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  ::execv(program.c_str(), argv.data());
  if (errno == ENOENT)
    throw std::runtime_error(
        "fitting needs odom-fit: install the package odom-fit, or libceres-dev and build again");
  throw std::runtime_error(program.string() + ": " + std::strerror(errno));
}

}  // namespace

void add_fit(CLI::App& identify) {
  auto options = std::make_shared<FitOptions>();
  CLI::App& method = *identify.add_subcommand("fit");
  describe_fit(method, *options);
  method.callback([options, &method] { become_odom_fit(method, *options); });
}

}  // namespace odomd::tools
