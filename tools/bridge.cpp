// odom bridge: the pose for other programs. JSON over UDP goes from here; for ROS 2 topics the
// program odom-bridge takes over, which alone is linked with DDS.
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "tools/bridge/bridge.hpp"
#include "tools/bridge/options.hpp"
#include "tools/bridge/udp_sink.hpp"
#include "tools/commands.hpp"
#include "tools/interrupt.hpp"

namespace odomd::tools {
namespace {

// Never comes back.
void become_odom_bridge(const BridgeOptions& options) {
  check_names(options.names);
  static_cast<void>(domain_of(options));  // what is wrong with it is said here, too
  const auto program =
      std::filesystem::read_symlink("/proc/self/exe").parent_path() / "odom-bridge";
  std::vector<std::string> arguments = arguments_of(options);
  arguments.insert(arguments.begin(), program.string());
  std::vector<char*> argv;
  argv.reserve(arguments.size() + 1);
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  ::execv(program.c_str(), argv.data());
  if (errno == ENOENT)
    throw std::runtime_error(
        "ROS 2 topics need odom-bridge: install the package odom-bridge, or cyclonedds-dev and "
        "cyclonedds-tools and build again; --udp works without");
  throw std::runtime_error(program.string() + ": " + std::strerror(errno));
}

void run_here(const BridgeOptions& options) {
  std::vector<std::unique_ptr<Sink>> sinks;
  sinks.push_back(open_udp(options.udp));
  run_bridge(options, sinks);
}

}  // namespace

void add_bridge(Command odom) {
  auto options = std::make_shared<BridgeOptions>();
  Command command = odom.add_subcommand("bridge");
  describe_bridge(command, *options);
  command.callback([options] {
    if (options->wants_ros())
      become_odom_bridge(*options);
    else
      run_here(*options);
  });
}

}  // namespace odomd::tools
