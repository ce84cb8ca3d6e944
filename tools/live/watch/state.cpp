#include "tools/live/watch/state.hpp"

#include <cmath>

namespace odomd::tools::watch {

void Trail::take(const odom_pose& pose, std::uint64_t instance) {
  if (pose.mode == ODOM_INITIALISING || !std::isfinite(pose.x) || !std::isfinite(pose.y)) return;
  // Every camera pose corrects the map pose by centimetres; only a leap breaks the line.
  const bool leapt = pose.reset_count != resets_ && std::hypot(pose.jump_x, pose.jump_y) > leap_m;
  const bool joined = !points_.empty() && instance == instance_ && !leapt;
  if (joined && std::hypot(pose.x - points_.back().x, pose.y - points_.back().y) < spacing_m) {
    return;
  }
  instance_ = instance;
  resets_ = pose.reset_count;
  points_.push_back({pose.x, pose.y, joined});
  if (points_.size() > longest) points_.pop_front();
}

double Trail::length() const {
  double length = 0.0;
  for (std::size_t i = 1; i < points_.size(); ++i) {
    if (!points_[i].joined) continue;
    length += std::hypot(points_[i].x - points_[i - 1].x, points_[i].y - points_[i - 1].y);
  }
  return length;
}

}  // namespace odomd::tools::watch
