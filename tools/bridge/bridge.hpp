// odom bridge: its command line, the sinks, the samples that they receive, and the bridge itself,
// which follows the segment and passes on the samples that are due. The command line serves `odom`,
// which can send UDP itself, and the program odom-bridge, which also supports DDS.
#pragma once

#include <odom/types.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tools/cli/command.hpp"

namespace odomd::tools {

/// Names of the frames of REP 105.
struct FrameNames {
  std::string map = "map";
  std::string odom = "odom";
  std::string base = "base_link";
};

/// The frame of the pose in /odom.
enum class PoseFrame : std::uint8_t { odom, map };

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

class PoseIntake;

/// A published pose. The details are of the same tick, or of the newest one if the bridge fell
/// behind and fetched the pose from the history, which keeps no details.
struct BridgeSample {
  odom_pose pose{};
  odom_details details{};
  std::int64_t realtime_ns = 0;  ///< when the pose is valid, CLOCK_REALTIME
};

/// Sends samples. For use by one thread.
class Sink {
 public:
  Sink() = default;
  Sink(const Sink&) = delete;
  Sink& operator=(const Sink&) = delete;
  virtual ~Sink() = default;

  /// Blocks for at most a few milliseconds; counts samples that cannot be sent.
  virtual void send(const BridgeSample& sample) = 0;

  struct Counts {
    std::uint64_t sent = 0;
    std::uint64_t dropped = 0;  ///< could not be sent
    std::uint64_t withheld =
        0;  ///< poses in the mode fault that were not sent, as the format has no modes
  };
  [[nodiscard]] const Counts& counts() const { return counts_; }
  [[nodiscard]] const std::string& name() const { return name_; }

 protected:
  Counts counts_;
  std::string name_;  ///< for messages
};

/// The address that PlotJuggler listens on by default.
inline constexpr const char* plotjuggler_address = "127.0.0.1:9870";

/// {"timestamp": seconds, "odomd": {"tick": ..., "map": {"x": ...}, ..., "mode_name": "tracking"}},
/// names and units as in pose_csv.hpp.
[[nodiscard]] std::string sample_json(const BridgeSample& sample);

/// Sends to HOST:PORT ([::1]:9870 for IPv6). Nobody needs to listen. Throws std::invalid_argument
/// for an invalid address, std::runtime_error for an unknown host.
[[nodiscard]] std::unique_ptr<Sink> open_udp(const std::string& address);

/// Sends nav_msgs/msg/Odometry on /odom and tf2_msgs/msg/TFMessage (map to odometry frame to base)
/// on /tf, with the defaults of ROS 2: reliable, volatile, keep last. A pose in the mode fault is
/// not sent: these messages cannot mark it as invalid. Throws std::runtime_error if DDS is not
/// available, std::invalid_argument for an invalid domain; CYCLONEDDS_URI configures DDS.
[[nodiscard]] std::unique_ptr<Sink> open_dds(const BridgeOptions& options);

/// Receives the topic of the options. Throws std::runtime_error if DDS is not available.
[[nodiscard]] std::unique_ptr<PoseIntake> open_pose_topic(const BridgeOptions& options);

/// Sends until INT, TERM or the end of the duration, then prints a summary. On a terminal it shows
/// the newest pose and the counts once a second, unless the summary is JSON. Waits if there is no
/// daemon, and reconnects when it restarts. Meanwhile polls `intake`, if there is one; without
/// sinks it does nothing else. It only reads the segment, so it cannot delay the daemon. Throws
/// std::invalid_argument for an invalid segment name, std::runtime_error if the segment is refused
/// or the duration passed without a daemon.
void run_bridge(const BridgeOptions& options, const std::vector<std::unique_ptr<Sink>>& sinks,
                PoseIntake* intake);

}  // namespace odomd::tools
