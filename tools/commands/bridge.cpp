// odom bridge: exchanges poses with other programs. Sends JSON over UDP itself; ROS 2 topics are
// left to the program odom-bridge, the only one linked with DDS.
#include "tools/bridge/bridge.hpp"
#include "tools/commands/commands.hpp"

namespace odomd::tools {

void add_bridge(Command odom) {
  auto options = std::make_shared<BridgeOptions>();
  Command command = odom.add_subcommand("bridge");
  describe_bridge(command, *options);
  command.callback([options, command] {
    complete(*options);
    if (options->publishes_ros() || !options->input.topic.empty()) {
      static_cast<void>(domain_of(*options));  // errors in the options are reported here, too
      hand_over(command, "odom-bridge",
                "ROS 2 topics need odom-bridge: install the package odom-bridge, or cyclonedds-dev "
                "and cyclonedds-tools and build all (cmake --preset release && cmake --build "
                "--preset release); --udp works without");
    }
    std::vector<std::unique_ptr<Sink>> sinks;
    sinks.push_back(open_udp(options->udp));
    run_bridge(*options, sinks, nullptr);
  });
}

}  // namespace odomd::tools
