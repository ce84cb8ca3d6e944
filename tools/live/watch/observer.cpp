#include "tools/live/watch/observer.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "base/wall_clock.hpp"
#include "tools/live/daemon_link.hpp"

namespace odomd::tools::watch {
namespace {

// Rates are measured over this time: in half a second, 28 Hz would flicker between 26 and 30.
constexpr std::int64_t rate_window_ns = 2'000'000'000;

}  // namespace

void Trail::take(const odom_pose& pose, std::uint64_t instance) {
  if (pose.mode == ODOM_INITIALISING || !std::isfinite(pose.x) || !std::isfinite(pose.y)) return;
  // Every camera pose corrects the map pose by centimetres; only a larger jump breaks the line.
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

Observer::Observer(Target target)
    : target_(std::move(target)),
      follows_socket_(target_.segment.empty() && !target_.socket.empty()) {
  state_.segment_name = follows_socket_ ? target_.socket : segment_asked_for(target_.segment);
}

void Observer::look(Depth depth) {
  state_.now_ns = monotonic_now();
  if (depth == Depth::segment_and_status) {
    look_at_status();
    if (follows_socket_) follow_socket();
  }
  if (!follows_socket_ || !target_.segment.empty()) look_at_segment();
  state_.now_ns = monotonic_now();  // after a slow answer, so that no pose is newer than this
}

std::optional<odom_pose> Observer::pose_at(std::int64_t time_ns) {
  if (!client_) return std::nullopt;
  const auto pose = client_->at(time_ns);
  return pose.has_value() ? std::optional{pose.value} : std::nullopt;
}

// Selects the segment of the daemon that answers; keeps the last one while nobody answers.
void Observer::follow_socket() {
  const std::string segment = state_.status ? segment_of(*state_.status) : target_.segment;
  if (segment.empty()) {
    state_.segment_problem = state_.status ? "its status names no segment; give it with --shm" : "";
  } else if (segment != target_.segment) {
    client_.reset();
    target_.segment = segment;
    state_.segment_name = segment;
  }
}

void Observer::look_at_segment() {
  // A daemon that has stopped may have a successor with another default name.
  if (state_.segment && state_.segment->silent) client_.reset();
  if (!client_) {
    auto opened = odom::Client::open(target_.segment.empty() ? nullptr : target_.segment.c_str());
    if (opened.status == ODOM_INVALID) {
      throw std::invalid_argument(state_.segment_name +
                                  ": not a name of a segment; use /odomd or a path");
    }
    if (!opened.has_value()) {
      state_.segment_problem = opened.message();
      return;
    }
    client_.emplace(std::move(opened.value));
  }
  const auto latest = client_->latest_details();
  const auto info = client_->info();
  const auto beat = client_->beat();
  if (!latest.has_value() || !info.has_value() || !beat.has_value()) {
    // Between two daemons the last state remains on the screen.
    state_.segment_problem = latest.message();
    if (state_.segment) state_.segment->silent = true;
    return;
  }
  if (state_.segment && state_.segment->info.instance_id != info->instance_id) ++state_.restarts;
  follow_trail(latest->pose, *info);
  state_.segment =
      Segment{latest->pose, latest->details, *info, *beat, latest.status == ODOM_STALE};
  state_.segment_problem.clear();
}

// Adds the path since the last look from the history, so that the trail is equally smooth however
// rarely we look.
void Observer::follow_trail(const odom_pose& pose, const odom_info& info) {
  const auto history_ns = static_cast<std::int64_t>(info.slots) * info.period_ns;
  std::int64_t time_ns = std::max(trail_ns_ + Trail::spacing_ns, pose.time_ns - history_ns);
  for (; time_ns < pose.time_ns; time_ns += Trail::spacing_ns) {
    const auto past = client_->at(time_ns);
    if (past.has_value()) state_.trail.take(*past, info.instance_id);
  }
  state_.trail.take(pose, info.instance_id);
  trail_ns_ = pose.time_ns;
}

void Observer::look_at_status() {
  constexpr auto timeout = std::chrono::milliseconds{300};
  state_.status.reset();
  state_.before.reset();
  try {
    state_.socket = socket_path(target_.socket, "status.sock");  // the socket may exist by now
    state_.status = parse_status(fetch_status(state_.socket, timeout), state_.socket);
    documents_.emplace_back(state_.now_ns, *state_.status);
    while (documents_.size() > 2 && state_.now_ns - documents_[1].first >= rate_window_ns)
      documents_.pop_front();
    if (documents_.size() > 1) state_.before = documents_.front().second;
    state_.status_problem.clear();
  } catch (const std::runtime_error& error) {
    state_.status_problem = error.what();
  }
}

}  // namespace odomd::tools::watch
