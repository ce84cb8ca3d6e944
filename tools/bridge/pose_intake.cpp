#include "tools/bridge/pose_intake.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tools/cli/csv.hpp"

namespace odomd::tools {
namespace {

CheckedPose check_stamp(std::int64_t stamp_ns, std::int64_t now_ns) {
  if (stamp_ns == 0)
    return {"no_stamp", "its stamp is 0; the publisher must set the time of the measurement"};
  const double age = static_cast<double>(now_ns - stamp_ns) * 1e-9;
  if (age < -0.005)  // the daemon's limit: a tick
    return {"future", fmt::format("its stamp is {:.3f} s ahead of this computer; synchronise the "
                                  "clocks (chrony, PTP)",
                                  -age)};
  if (age > 10.0)  // another clock's stamp
    return {"old", fmt::format("its stamp is {:.3f} s old; the publisher must use the system's "
                               "time (use_sim_time false), and the clocks must be synchronised",
                               age)};
  return {};
}

}  // namespace

CheckedPose check_pose(const RosPose& pose, const PoseInput& expected, std::int64_t now_ns) {
  const bool wrong_frame = pose.frame != expected.frame;
  if (wrong_frame || pose.child_frame.value_or(expected.child_frame) != expected.child_frame)
    return {wrong_frame ? "frame" : "child_frame",
            fmt::format("{} is {}, not {}; set it in the publisher, or name it with {}",
                        wrong_frame ? "header.frame_id" : "child_frame_id",
                        tools::quoted(wrong_frame ? pose.frame : *pose.child_frame),
                        tools::quoted(wrong_frame ? expected.frame : expected.child_frame),
                        wrong_frame ? "--pose-frame" : "--pose-child-frame")};
  CheckedPose checked = check_stamp(pose.stamp_ns, now_ns);
  if (!checked.refusal.empty()) return checked;
  const auto [qx, qy, qz, qw] = pose.rotation;
  const double square = qx * qx + qy * qy + qz * qz + qw * qw;
  if (!std::isfinite(pose.x + pose.y + square))
    return {"not_finite", "its pose has numbers that are not finite"};
  if (std::abs(std::sqrt(square) - 1.0) > 0.01)
    return {"rotation",
            fmt::format("its quaternion has the length {:.3f}, not 1", std::sqrt(square))};
  const double cos_tilt = 1.0 - 2.0 * (qx * qx + qy * qy) / square;
  if (cos_tilt < 0.5)
    return {"tilted",
            fmt::format("the car is tilted by {:.0f} degrees; the z axes of map and car must point "
                        "up (motion capture: choose Z up)",
                        std::acos(std::max(cos_tilt, -1.0)) * 180.0 / std::numbers::pi)};
  const auto sigma = [&](std::size_t axis, double least) {
    if (pose.covariance == nullptr) return least;
    const double variance = pose.covariance[axis * 7];
    if (std::isfinite(variance) && variance > 0.0) return std::max(least, std::sqrt(variance));
    checked.lacks_sigma = true;
    return least;
  };
  const double yaw = std::atan2(2.0 * (qw * qz + qx * qy), square - 2.0 * (qy * qy + qz * qz));
  checked.pose = {.capture_ns = pose.stamp_ns,
                  .x = pose.x,
                  .y = pose.y,
                  .yaw = yaw,
                  .sigma_x = sigma(0, expected.sigma[0]),
                  .sigma_y = sigma(1, expected.sigma[1]),
                  .sigma_yaw = sigma(5, expected.sigma[2])};
  return checked;
}

void PoseIntake::take(const RosPose& pose, std::int64_t now_ns) {
  const CheckedPose checked = check_pose(pose, input_, now_ns);
  ++counts_["received"];
  if (!checked.refusal.empty()) {
    ++counts_["refused_" + checked.refusal];
    // One message per wrong frame, and one per other reason: those texts differ with every pose.
    note(checked.refusal.ends_with("frame") ? checked.problem : checked.refusal,
         "a pose is refused: " + checked.problem);
    return;
  }
  ++counts_[send(checked.pose) ? "sent" : "unsent"];
  if (!checked.lacks_sigma) return;
  ++counts_["without_sigma"];
  note("sigma", fmt::format("a variance of x, y or yaw is zero, negative or not finite; such an "
                            "axis gets --pose-sigma ({})",
                            fmt::join(input_.sigma, ", ")));
}

bool PoseIntake::send(const estimator::CameraPose& pose) {
  std::string problem;
  try {
    if (!feed_) feed_.emplace(input_.socket, 0.0);
    if (feed_->send(pose, ODOM_CLOCK_REALTIME)) return true;
    problem = feed_->refusal();
    if (problem.empty()) problem = feed_->socket() + ": no daemon takes the poses";
  } catch (const std::exception& error) {
    problem = error.what();
  }
  note(problem, problem);
  return false;
}

void PoseIntake::note(const std::string& key, const std::string& message) {
  if (noted_.size() < 50 && noted_.insert(key).second)
    messages_.push_back(input_.topic + ": " + message);
}

}  // namespace odomd::tools
