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

// Never comes back.
void become_odom_fit(Command command, const FitOptions& options) {
  check(options);
  const auto program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "odom-fit";
  std::vector<std::string> arguments = command.given();
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

void add_fit(Command identify) {
  auto options = std::make_shared<FitOptions>();
  Command method = identify.add_subcommand("fit");
  describe_fit(method, *options);
  method.callback([options, method] { become_odom_fit(method, *options); });
}

}  // namespace odomd::tools
