// The command line of odom bridge: one for `odom`, which can send UDP itself, and one for the
// program odom-bridge, which also supports DDS.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tools/bridge/odometry.hpp"
#include "tools/cli/command.hpp"

namespace odomd::tools {

/// Names of the frames of REP 105.
struct FrameNames {
  std::string map = "map";
  std::string odom = "odom";
  std::string base = "base_link";
};

/// What goes to /tf. Each transform must have one publisher: send less if there is another.
enum class Transforms : std::uint8_t { all, odom, none };

struct BridgeOptions {
  std::string shm;
  double rate_hz = 50.0;
  double duration_s = 0.0;  ///< 0: without end
  bool ros = false;         ///< requested explicitly
  std::string udp;          ///< empty: not requested
  std::string domain;       ///< empty: $ROS_DOMAIN_ID, else 0
  PoseFrame frame = PoseFrame::odom;
  Transforms transforms = Transforms::all;
  FrameNames names;
  bool json = false;

  /// ROS topics are the default if no output is given.
  [[nodiscard]] bool wants_ros() const { return ros || udp.empty(); }
};

/// Throws std::invalid_argument if two frames have the same name.
void check_names(const FrameNames& names);

/// Adds the options, the description and the examples.
void describe_bridge(Command command, BridgeOptions& options);

/// The same options, as arguments.
[[nodiscard]] std::vector<std::string> arguments_of(const BridgeOptions& options);

/// The requested DDS domain. Throws std::invalid_argument unless it is a number from 0 to 232.
[[nodiscard]] std::uint32_t domain_of(const BridgeOptions& options);

}  // namespace odomd::tools
