#include "estimator/baselines/pose_anchor.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "estimator/common/admission.hpp"
#include "estimator/common/time.hpp"

namespace odomd::estimator {
namespace {

// A kilometre says that nothing is known; so does half a turn.
constexpr std::array<double, 3> largest_variance{1e6, 1e6, std::numbers::pi* std::numbers::pi};
// Rounding takes the last digits of a strongly correlated P; this keeps it positive definite, and
// makes it 1.7 % larger in a day.
constexpr double inflation = 1.0 + 1e-9;

// What the odometry may err by when it is in doubt: half of what it says, and this on top.
constexpr double doubted_share = 0.5;
constexpr double doubted_speed = 0.5;     // [m/s]
constexpr double doubted_yaw_rate = 1.0;  // [rad/s]
constexpr double longest_pause_s = 0.5;   // between rejected camera poses of one run

/// The covariance of a displacement by an odometry that is in doubt, its error the same throughout.
Symmetric3 doubted(const Pose2& from, const Pose2& to, double dt) noexcept {
  const double distance = std::hypot(to.x - from.x, to.y - from.y);
  const double position = doubted_share * distance + doubted_speed * dt;
  const double yaw = doubted_share * std::abs(to.yaw - from.yaw) + doubted_yaw_rate * dt;
  return diagonal(position * position, position * position, yaw * yaw);
}

/// P after the displacement from one odometry pose to another, seen in a frame turned by `yaw`.
Symmetric3 propagated(const Symmetric3& p, const Pose2& from, const Pose2& to, double yaw,
                      const Symmetric3& noise) noexcept {
  const double c = std::cos(yaw);
  const double s = std::sin(yaw);
  const double dx = to.x - from.x;
  const double dy = to.y - from.y;
  // P ← F P Fᵀ + Q, the displacement and the noise turned into the frame
  Symmetric3 next = sum(displaced(p, c * dx - s * dy, s * dx + c * dy), rotated(noise, c, s));
  next[0] *= inflation;
  next[3] *= inflation;
  next[5] *= inflation;
  return limited(next, largest_variance);
}

Symmetric3 covariance_of(const CameraPose& camera) noexcept {
  const auto variance = [](double sigma) {
    const double bounded = std::clamp(sigma, smallest_sigma, largest_camera_sigma);
    return bounded * bounded;
  };
  return limited(
      diagonal(variance(camera.sigma_x), variance(camera.sigma_y), variance(camera.sigma_yaw)),
      largest_variance);
}

/// ν = camera - map, the yaw by the shorter way.
std::array<double, 3> innovation(const Pose2& camera, const Pose2& map) noexcept {
  return {camera.x - map.x, camera.y - map.y, wrap_angle(camera.yaw - map.yaw)};
}

Pose2 interpolated(const Pose2& a, const Pose2& b, double share) noexcept {
  return {std::lerp(a.x, b.x, share), std::lerp(a.y, b.y, share), std::lerp(a.yaw, b.yaw, share)};
}

}  // namespace

PoseAnchor::PoseAnchor(const FilterSettings& settings) noexcept
    : max_latency_s_(settings.camera_max_latency_s),
      gate_(settings.camera_gate),
      period_s_(settings.period_s),
      initialise_from_camera_(settings.initialise_from_camera),
      initial_covariance_(
          diagonal(settings.initial_sigma_position * settings.initial_sigma_position,
                   settings.initial_sigma_position * settings.initial_sigma_position,
                   settings.initial_sigma_yaw * settings.initial_sigma_yaw)) {
  ring_[head_].covariance = initial_covariance_;
}

void PoseAnchor::set_pose(const Pose2& pose) noexcept {
  const Located now{newest().odom, newest().covariance, 0, 0.0};
  if (!initialised_) {
    rebase(frame_of(pose, newest().odom));
    initialised_ = true;
    ++reset_count_;
    ring_[head_].covariance = initial_covariance_;
    return;
  }
  re_anchor(now, pose, initial_covariance_);
}

void PoseAnchor::resume(const Pose2& map, const Pose2& odom, const Symmetric3& covariance,
                        std::uint32_t reset_count) noexcept {
  count_ = 0;
  ring_[head_] = {0, odom, {}, limited(covariance, largest_variance)};
  map_from_odom_ = frame_of(map, odom);
  initialised_ = true;
  reset_count_ = reset_count;
  last_jump_ = {};
  contender_ = {};
}

void PoseAnchor::start(std::int64_t time_ns) noexcept {
  ring_[head_].time_ns = time_ns;
  count_ = 1;
}

void PoseAnchor::extend(std::int64_t time_ns, const Pose2& odom, const Symmetric3& noise,
                        const BodyVelocity& velocity) noexcept {
  const Tick& before = newest();
  const Symmetric3 added = sum(noise, distrust_noise(time_ns, odom));
  const Tick tick{time_ns, odom, added,
                  propagated(before.covariance, before.odom, odom, map_from_odom_.yaw, added)};
  head_ = (head_ + 1) % ring_ticks;
  count_ = std::min(count_ + 1, ring_ticks);
  ring_[head_] = tick;
  velocity_ = velocity;
}

Verdict PoseAnchor::take(const CameraPose& camera, std::int64_t latest_ns,
                         std::int64_t now_ns) noexcept {
  if (!is_usable(camera)) {
    return Verdict::non_finite;
  }
  if (camera.capture_ns > latest_ns) {
    return Verdict::future;
  }
  const std::int64_t arrival_ns = camera.arrival_ns != 0 ? camera.arrival_ns : now_ns;
  if (seconds_between(camera.capture_ns, arrival_ns) > max_latency_s_) {
    return Verdict::too_old;
  }
  if (camera.capture_ns == judged_capture_ns_ && camera.capture_ns != 0) {
    return Verdict::duplicate;
  }
  // Until the history begins, a newer pose initialises anew.
  const bool initialises = !initialised_ || (count_ == 0 && fused_capture_ns_ != 0);
  std::optional<Located> at = locate(camera.capture_ns);
  if (!at && initialises) {
    at = before_history(camera.capture_ns);
  }
  const bool before_the_last = fused_capture_ns_ != 0 && camera.capture_ns < fused_capture_ns_;
  if (!at || before_the_last) {
    return Verdict::too_old;
  }
  if (std::abs(camera.x) > largest_coordinate || std::abs(camera.y) > largest_coordinate) {
    return Verdict::gated;
  }
  if (!initialised_ && !initialise_from_camera_) {
    return Verdict::source_off;
  }

  const Symmetric3 R = covariance_of(camera);
  judged_capture_ns_ = camera.capture_ns;
  if (initialises) {
    const Pose2 seen{camera.x, camera.y, wrap_angle(camera.yaw)};
    Located there = *at;
    const Pose2 odom_from_old = frame_of(seen, there.odom);
    rebase(odom_from_old);
    there.odom = seen;
    re_anchor(there, seen, R);
    initialised_ = true;
    reset_count_ = 1;
    last_jump_ = {};
    fused_capture_ns_ = camera.capture_ns;
    test_ratio_ = 0.0;
    return Verdict::fused;
  }

  // ν = camera - map(t_capture),  S = P(t_capture) + R,  νᵀS⁻¹ν <= gate
  const Pose2 believed = compose(map_from_odom_, at->odom);
  const std::array<double, 3> nu = innovation({camera.x, camera.y, camera.yaw}, believed);
  const double distance = mahalanobis_squared(sum(at->covariance, R), nu);
  test_ratio_ = distance / gate_;
  // The turn that continues the map yaw.
  const Pose2 seen{camera.x, camera.y, believed.yaw + nu[2]};
  if (!(distance <= gate_)) {
    if (!contenders_agree({1, camera.capture_ns, seen, at->odom, R})) {
      return Verdict::gated;
    }
    distrusted_until_ns_ = ns_after(newest().time_ns, std::llround(distrust_s * ns_per_second));
  }
  re_anchor(*at, seen, R);
  fused_capture_ns_ = camera.capture_ns;
  return Verdict::fused;
}

/// Finds `time_ns` among the ticks: between two of them by interpolation, after the newest by its
/// velocity. Nothing where it is older than all.
std::optional<PoseAnchor::Located> PoseAnchor::locate(std::int64_t time_ns) const noexcept {
  if (count_ == 0) {
    return std::nullopt;
  }
  const double yaw = map_from_odom_.yaw;
  if (time_ns >= newest().time_ns) {
    const double ahead_s = seconds_between(newest().time_ns, time_ns);
    const Pose2 odom = moved(newest().odom, velocity_, ahead_s);
    const double steps = ahead_s / period_s_;
    return Located{
        odom,
        propagated(newest().covariance, newest().odom, odom, yaw, scaled(newest().noise, steps)), 0,
        steps};
  }
  for (std::size_t age = 1; age < count_; ++age) {
    const Tick& before = by_age(age);
    if (before.time_ns > time_ns) {
      continue;
    }
    const Tick& after = by_age(age - 1);
    const double share =
        seconds_between(before.time_ns, time_ns) / seconds_between(before.time_ns, after.time_ns);
    const Pose2 odom = interpolated(before.odom, after.odom, share);
    return Located{
        odom, propagated(before.covariance, before.odom, odom, yaw, scaled(after.noise, share)),
        age, 1.0 - share};
  }
  return std::nullopt;
}

/// Where the car was before the history begins, for a pose that initialises: it moved as it does
/// now, and as long as there is no history it stood. Nothing where the ring has forgotten the
/// beginning.
std::optional<PoseAnchor::Located> PoseAnchor::before_history(std::int64_t time_ns) const noexcept {
  if (count_ == 0) {
    return Located{newest().odom, newest().covariance, 0, 0.0};
  }
  if (count_ == ring_ticks) {
    return std::nullopt;
  }
  const Tick& oldest = by_age(count_ - 1);
  const double dt = seconds_between(oldest.time_ns, time_ns);
  return Located{moved(oldest.odom, velocity_, dt), oldest.covariance, count_, -dt / period_s_};
}

/// Keeps account of the rejected: true once enough of them in a row say the same.
bool PoseAnchor::contenders_agree(const Contender& rejected) noexcept {
  const Contender before = contender_;
  contender_ = rejected;
  const double dt = seconds_between(before.capture_ns, rejected.capture_ns);
  if (before.agreeing == 0 || dt <= 0.0 || dt > longest_pause_s) {
    return false;
  }
  // ν = camera - (the one before, moved on by the odometry), S = both covariances and the doubt
  const Pose2 expected = compose(frame_of(before.map, before.odom), rejected.odom);
  const Symmetric3 S =
      sum(sum(displaced(before.covariance, expected.x - before.map.x, expected.y - before.map.y),
              rejected.covariance),
          doubted(before.odom, rejected.odom, dt));
  if (mahalanobis_squared(S, innovation(rejected.map, expected)) <= gate_) {
    contender_.agreeing = before.agreeing + 1;
  }
  return contender_.agreeing >= agreeing_rejections;
}

/// What a step of an odometry in distrust adds to the noise. Its error stays the same from tick to
/// tick, so n ticks after the last camera pose σ is n σ_1, and a tick adds σ_1² (2n - 1).
Symmetric3 PoseAnchor::distrust_noise(std::int64_t time_ns, const Pose2& odom) const noexcept {
  if (time_ns > distrusted_until_ns_ || distrusted_until_ns_ == 0) {
    return {};
  }
  const double ticks = seconds_between(fused_capture_ns_, time_ns) / period_s_;
  const double n = std::clamp(ticks, 1.0, 40.0);
  return scaled(doubted(newest().odom, odom, period_s_), 2.0 * n - 1.0);
}

/// Puts the map pose at `at` to `map`, and lets its covariance grow from there to the newest tick.
void PoseAnchor::re_anchor(const Located& at, const Pose2& map,
                           const Symmetric3& covariance) noexcept {
  const Pose2 map_before = this->map();
  map_from_odom_ = frame_of(map, at.odom);
  const double yaw = map_from_odom_.yaw;

  Symmetric3 P = covariance;
  Pose2 from = at.odom;
  if (at.ticks_after == 0) {
    // Seen a little after the newest tick: back to it.
    P = propagated(P, from, newest().odom, yaw, scaled(newest().noise, at.rest));
    ring_[head_].covariance = P;
  }
  double share = at.rest;
  for (std::size_t age = at.ticks_after; age-- > 0;) {
    Tick& tick = by_age(age);
    P = propagated(P, from, tick.odom, yaw, scaled(tick.noise, share));
    tick.covariance = P;
    from = tick.odom;
    share = 1.0;
  }

  const Pose2 map_after = this->map();
  last_jump_ = {map_after.x - map_before.x, map_after.y - map_before.y,
                map_after.yaw - map_before.yaw};
  ++reset_count_;
  contender_ = {};
}

/// Moves the odometry frame itself: only before anyone has seen a pose in it.
void PoseAnchor::rebase(const Pose2& odom_from_old) noexcept {
  const double c = std::cos(odom_from_old.yaw);
  const double s = std::sin(odom_from_old.yaw);
  for (Tick& tick : ring_) {
    tick.odom = compose(odom_from_old, tick.odom);
    tick.noise = rotated(tick.noise, c, s);
    tick.covariance = rotated(tick.covariance, c, s);
  }
  map_from_odom_ = {};
}

}  // namespace odomd::estimator
