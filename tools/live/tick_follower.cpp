#include "tools/live/tick_follower.hpp"

#include <stdexcept>
#include <utility>

namespace odomd::tools {

TickFollower::TickFollower(odom::Client client) : client_(std::move(client)) {
  const auto newest = client_.latest();
  const auto info = client_.info();
  if (!newest.has_value() || !info.has_value()) return;
  last_ = *newest;
  instance_ = info->instance_id;
}

odom_status TickFollower::follow(std::chrono::nanoseconds timeout,
                                 const std::function<void(const odom_pose&)>& take) {
  const auto pose = client_.wait(last_.value_or(odom_pose{}), timeout);
  if (!pose.has_value()) return pose.status;
  if (last_ && pose->time_ns <= last_->time_ns) return ODOM_STALE;  // the same tick again

  const auto info = client_.info();
  if (!info.has_value()) return info.status;
  if (last_ && info->instance_id == instance_) {
    catch_up(*pose, *info, last_->tick + 1, take);
  } else {
    if (counts_.ticks > 0) ++counts_.restarts;
    catch_up(*pose, *info, 0, take);
  }
  instance_ = info->instance_id;
  last_ = *pose;
  ++counts_.ticks;
  take(*pose);
  return ODOM_OK;
}

bool TickFollower::falls_silent(odom_status status) {
  if (status == ODOM_TIMEOUT || status == ODOM_NO_POSE || status == ODOM_BUSY) return false;
  if (status != ODOM_OK && status != ODOM_STALE) throw std::runtime_error(odom_strstatus(status));
  return !std::exchange(silent_, status == ODOM_STALE) && silent_;
}

// Ticks [first, newest): tick k is valid (newest - k) periods before the newest. For a tick that
// was never published the library interpolates or fails; either way it does not return tick k.
void TickFollower::catch_up(const odom_pose& newest, const odom_info& info, std::uint64_t first,
                            const std::function<void(const odom_pose&)>& take) {
  const bool same_daemon = first != 0;
  std::uint64_t k = first;
  if (newest.tick - first > info.slots) {
    k = newest.tick - info.slots;
    counts_.lost += k - first;
  }
  for (; k < newest.tick; ++k) {
    const auto behind = static_cast<std::int64_t>(newest.tick - k) * info.period_ns;
    const auto past = client_.at(newest.time_ns - behind);
    if (past.has_value() && past->tick == k) {
      ++counts_.ticks;
      ++counts_.fetched;
      take(*past);
    } else if (past.status == ODOM_TOO_OLD) {
      if (same_daemon) ++counts_.lost;  // a new daemon's first tick is later than these
    } else {
      ++counts_.unpublished;
    }
  }
}

}  // namespace odomd::tools
