// The command line of odom bridge: one for `odom`, which can send UDP itself, and one for the
// program odom-bridge, which also supports DDS.
#pragma once

#include <cstdint>
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

/// The transforms sent to /tf. Each must have one publisher: omit those that another node sends.
enum class Transforms : std::uint8_t { all, odom, none };

/// The topic whose poses go to the daemon's camera socket.
struct PoseInput {
  std::string topic;                            ///< "/pose"; empty: none
  std::string frame;                            ///< expected header.frame_id
  std::string child_frame = "base_link";        ///< expected child_frame_id of an Odometry
  std::vector<double> sigma{0.01, 0.01, 0.01};  ///< smallest sigmas of x, y, yaw [m, m, rad]
  std::string socket;                           ///< empty: the daemon's default
};

struct BridgeOptions {
  std::string shm;
  double rate_hz = 50.0;
  double duration_s = 0.0;  ///< 0: no limit
  bool ros = false;         ///< requested explicitly
  std::string udp;          ///< empty: not requested
  std::string domain;       ///< empty: $ROS_DOMAIN_ID, or 0 if unset
  PoseFrame frame = PoseFrame::odom;
  Transforms transforms = Transforms::all;
  FrameNames names;
  PoseInput input;
  bool no_publish = false;  ///< receive only
  bool json = false;

  /// ROS topics are the default if no output is given.
  [[nodiscard]] bool publishes_ros() const { return ros || (udp.empty() && !no_publish); }
};

/// Completes the options. Throws std::invalid_argument if some contradict each other.
void complete(BridgeOptions& options);

/// Adds the options, the description and the examples.
void describe_bridge(Command command, BridgeOptions& options);

/// The requested DDS domain. Throws std::invalid_argument unless it is a number from 0 to 232.
[[nodiscard]] std::uint32_t domain_of(const BridgeOptions& options);

}  // namespace odomd::tools
