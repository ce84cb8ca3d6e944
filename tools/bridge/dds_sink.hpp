// Poses as ROS 2 topics, by Cyclone DDS and without ROS: rt/odom and rt/tf.
#pragma once

#include <memory>

#include "tools/bridge/options.hpp"
#include "tools/bridge/sample.hpp"

namespace odomd::tools {

/// nav_msgs/msg/Odometry on /odom, tf2_msgs/msg/TFMessage (map to odometry frame to base) on /tf,
/// as ROS 2 sends them by default: reliable, volatile, keep last. A pose in the mode fault is not
/// sent: these messages cannot mark it as invalid. Throws std::runtime_error if DDS is not
/// available, std::invalid_argument for an invalid domain; CYCLONEDDS_URI configures DDS.
[[nodiscard]] std::unique_ptr<Sink> open_dds(const BridgeOptions& options);

}  // namespace odomd::tools
