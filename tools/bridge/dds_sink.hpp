// Poses as ROS 2 topics, by Cyclone DDS and without ROS: rt/odom and rt/tf.
#pragma once

#include <memory>

#include "tools/bridge/options.hpp"
#include "tools/bridge/sample.hpp"

namespace odomd::tools {

/// nav_msgs/msg/Odometry on /odom, tf2_msgs/msg/TFMessage (map to odometry frame to base) on /tf,
/// as ROS 2 sends them by default: reliable, volatile, keep last. A pose in the mode fault is
/// withheld: these messages cannot say that it means nothing. Throws std::runtime_error where DDS
/// cannot be had, std::invalid_argument for a domain that is none; CYCLONEDDS_URI configures it.
[[nodiscard]] std::unique_ptr<Sink> open_dds(const BridgeOptions& options);

}  // namespace odomd::tools
