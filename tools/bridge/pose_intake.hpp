// Checks the car's poses in ROS 2 messages, and sends them to the daemon's camera socket or refuses
// them. No DDS in here.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tools/bridge/bridge.hpp"
#include "tools/live/daemon_feeds.hpp"

namespace odomd::tools {

/// The content that all message types share. Points into a message.
struct RosPose {
  std::int64_t stamp_ns = 0;  ///< CLOCK_REALTIME
  std::string_view frame;
  std::optional<std::string_view> child_frame;  ///< of an Odometry
  double x = 0.0;
  double y = 0.0;
  std::array<double, 4> rotation{};    ///< quaternion x, y, z, w
  const double* covariance = nullptr;  ///< laid out like Covariance6; null: none
};

struct CheckedPose {
  std::string refusal;         ///< name of the reason; empty: the pose is good
  std::string problem;         ///< the reason in words, with the fix
  estimator::CameraPose pose;  ///< capture time on CLOCK_REALTIME
  bool lacks_sigma = false;    ///< a variance is zero, negative or not finite
};

/// `now_ns` is CLOCK_REALTIME. Sigmas are at least those of the options.
[[nodiscard]] CheckedPose check_pose(const RosPose& pose, const PoseInput& expected,
                                     std::int64_t now_ns);

class PoseIntake {
 public:
  explicit PoseIntake(PoseInput input) : input_(std::move(input)) {}
  virtual ~PoseIntake() = default;

  /// Takes the poses that have arrived; waits for the first pose at most this long.
  virtual void poll(std::chrono::milliseconds /*wait*/) {}
  /// Checks the pose and sends it. Waits some milliseconds for a daemon that does not keep up.
  void take(const RosPose& pose, std::int64_t now_ns);
  /// Adds a message for the user, unless one with this key was added before.
  void note(const std::string& key, const std::string& message);
  /// The messages since the last call.
  [[nodiscard]] std::vector<std::string> take_messages() { return std::exchange(messages_, {}); }

  /// received, sent, unsent (no daemon took them), refused_REASON, without_sigma.
  [[nodiscard]] const std::map<std::string, std::uint64_t>& counts() const { return counts_; }
  [[nodiscard]] const std::string& topic() const { return input_.topic; }

 private:
  bool send(const estimator::CameraPose& pose);

  PoseInput input_;
  std::optional<CameraFeed> feed_;
  std::map<std::string, std::uint64_t> counts_{{"received", 0}, {"sent", 0}, {"unsent", 0}};
  std::set<std::string> noted_;
  std::vector<std::string> messages_;
};

}  // namespace odomd::tools
