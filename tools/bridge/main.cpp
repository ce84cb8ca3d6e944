// odom-bridge: odom bridge with ROS 2 topics, out and in. A separate program, so that odom itself
// does not depend on DDS.
#include <memory>
#include <vector>

#include "tools/bridge/bridge.hpp"
#include "tools/bridge/pose_intake.hpp"
#include "tools/cli/command_line.hpp"
#include "tools/cli/output.hpp"

namespace odomd::tools {
namespace {

void bridge(BridgeOptions& options) {
  complete(options);
  // Blocks signals before DDS starts threads, which inherit this: only this thread may get signals.
  const Interrupt held_back;
  std::vector<std::unique_ptr<Sink>> sinks;
  if (options.publishes_ros()) sinks.push_back(open_dds(options));
  if (!options.udp.empty()) sinks.push_back(open_udp(options.udp));
  const auto intake = options.input.topic.empty() ? nullptr : open_pose_topic(options);
  run_bridge(options, sinks, intake.get());
}

}  // namespace
}  // namespace odomd::tools

int main(int argc, char** argv) {
  odomd::tools::BridgeOptions options;
  const auto describe = [&options](odomd::tools::Command command) {
    command.program("odom bridge", "odom-bridge " ODOMD_VERSION);
    odomd::tools::describe_bridge(command, options);
    command.callback([&options] { odomd::tools::bridge(options); });
  };
  return odomd::tools::run_program(describe, argc, argv);
}
