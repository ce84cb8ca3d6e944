#include "estimator/baselines/pose_anchor.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "estimator/common/time.hpp"
#include "estimator/integrity/admission.hpp"

namespace odomd::estimator {
namespace {

// A kilometre says that nothing is known; so does half a turn.
constexpr std::array<double, 3> largest_variance{1e6, 1e6, std::numbers::pi* std::numbers::pi};
// Rounding takes the last digits of a strongly correlated P; this keeps it positive definite, and
// makes it 1.7 % larger in a day.
constexpr double inflation = 1.0 + 1e-9;

// Once a run of rejected camera poses is believed, the odometry is suspect for so long.
constexpr double suspect_s = 2.0;

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

Symmetric3 of_sigmas(double x, double y, double yaw) noexcept {
  return diagonal(x * x, y * y, yaw * yaw);
}

Symmetric3 covariance_of(const CameraPose& camera) noexcept {
  const auto bounded = [](double sigma) {
    return std::clamp(sigma, smallest_sigma, largest_camera_sigma);
  };
  return limited(
      of_sigmas(bounded(camera.sigma_x), bounded(camera.sigma_y), bounded(camera.sigma_yaw)),
      largest_variance);
}

}  // namespace

PoseAnchor::PoseAnchor(const FilterSettings& settings) noexcept
    : settings_(settings),
      initial_covariance_(of_sigmas(settings.initial_sigma_position,
                                    settings.initial_sigma_position, settings.initial_sigma_yaw)) {
  ring_[head_].covariance = initial_covariance_;
}

void PoseAnchor::set_pose(const Pose2& pose) noexcept {
  if (initialised_) {
    re_anchor({newest().odom, newest().covariance}, pose, initial_covariance_);
    return;
  }
  rebase(frame_of(pose, newest().odom));
  initialised_ = true;
  ++reset_count_;
  ring_[head_].covariance = initial_covariance_;
}

void PoseAnchor::resume(const Estimate& predecessor) noexcept {
  count_ = 0;
  ring_[head_] = {0, predecessor.odom, {}, limited(predecessor.covariance, largest_variance)};
  map_from_odom_ = frame_of(predecessor.map, predecessor.odom);
  initialised_ = true;
  reset_count_ = predecessor.reset_count + 1;
  last_jump_ = {};
  rejected_ = {};
}

void PoseAnchor::start(std::int64_t time_ns) noexcept {
  ring_[head_].time_ns = time_ns;
  count_ = 1;
}

void PoseAnchor::extend(std::int64_t time_ns, const Pose2& odom, const Symmetric3& noise,
                        const BodyVelocity& velocity) noexcept {
  const Tick& before = newest();
  Symmetric3 suspicion{};
  if (time_ns <= suspect_until_ns_ && suspect_until_ns_ != 0) {
    // The error stays the same from tick to tick, so n ticks after the last camera pose σ is n σ_1,
    // and a tick adds σ_1² (2n - 1).
    const double ticks = seconds_between(fused_capture_ns_, time_ns) / settings_.period_s;
    const double n = std::clamp(ticks, 1.0, 40.0);
    suspicion = scaled(suspect_motion(before.odom, odom, settings_.period_s), 2.0 * n - 1.0);
  }
  const Symmetric3 added = sum(noise, suspicion);
  const Tick tick{time_ns, odom, added,
                  propagated(before.covariance, before.odom, odom, map_from_odom_.yaw, added)};
  head_ = (head_ + 1) % ring_ticks;
  count_ = std::min(count_ + 1, ring_ticks);
  ring_[head_] = tick;
  velocity_ = velocity;
}

Verdict PoseAnchor::take(const CameraPose& camera, std::int64_t latest_ns,
                         std::int64_t arrival_ns) noexcept {
  if (!is_usable(camera)) {
    return Verdict::non_finite;
  }
  if (camera.capture_ns > latest_ns) {
    return Verdict::future;
  }
  if (seconds_between(camera.capture_ns, arrival_ns) > settings_.camera_max_latency_s) {
    return Verdict::too_old;
  }
  if (camera.capture_ns == judged_capture_ns_ && camera.capture_ns != 0) {
    return Verdict::duplicate;
  }
  // Until the history begins, a newer pose initialises anew.
  const bool initialises = !initialised_ || (count_ == 0 && fused_capture_ns_ != 0);
  const std::optional<Place> at = place(camera.capture_ns, initialises);
  if (!at || (fused_capture_ns_ != 0 && camera.capture_ns < fused_capture_ns_)) {
    return Verdict::too_old;
  }
  if (std::abs(camera.x) > largest_coordinate || std::abs(camera.y) > largest_coordinate) {
    return Verdict::gated;
  }
  if (!initialised_ && !settings_.initialise_from_camera) {
    return Verdict::source_off;
  }

  const Symmetric3 R = covariance_of(camera);
  judged_capture_ns_ = camera.capture_ns;
  if (initialises) {
    initialise({camera.x, camera.y, wrap_angle(camera.yaw)}, *at, R);
  } else {
    // ν = camera - map(t_capture),  S = P(t_capture) + R,  νᵀS⁻¹ν <= gate
    const Pose2 believed = compose(map_from_odom_, at->odom);
    const std::array<double, 3> nu = difference({camera.x, camera.y, camera.yaw}, believed);
    const double distance = mahalanobis_squared(sum(at->covariance, R), nu);
    test_ratio_ = distance / settings_.camera_gate;
    // The turn that continues the map yaw.
    const Pose2 seen{camera.x, camera.y, believed.yaw + nu[2]};
    if (!(distance <= settings_.camera_gate)) {
      if (!agree(rejected_, {camera.capture_ns, seen, at->odom, R}, settings_.camera_gate)) {
        return Verdict::gated;
      }
      suspect_until_ns_ = ns_after(newest().time_ns, std::llround(suspect_s * ns_per_second));
    }
    re_anchor(*at, seen, R);
  }
  fused_capture_ns_ = camera.capture_ns;
  return Verdict::fused;
}

/// Finds `time_ns` among the ticks: between two of them by interpolation, after the newest by its
/// velocity. Before the oldest there is only a place for a pose that initialises: the car moved as
/// it does now, and as long as there is no history it stood.
std::optional<PoseAnchor::Place> PoseAnchor::place(std::int64_t time_ns,
                                                   bool initialises) const noexcept {
  const auto place_after = [&](const Tick& tick, const Pose2& odom, const Symmetric3& noise,
                               std::size_t age, double steps) {
    return Place{odom, propagated(tick.covariance, tick.odom, odom, map_from_odom_.yaw, noise), age,
                 steps};
  };
  if (count_ > 0 && time_ns >= newest().time_ns) {
    const double ahead_s = seconds_between(newest().time_ns, time_ns);
    const double steps = ahead_s / settings_.period_s;
    return place_after(newest(), moved(newest().odom, velocity_, ahead_s),
                       scaled(newest().noise, steps), 0, steps);
  }
  for (std::size_t age = 0; age + 1 < count_; ++age) {
    const Tick& before = ring_[index(age + 1)];
    if (before.time_ns > time_ns) {
      continue;
    }
    const Tick& after = ring_[index(age)];
    const double share =
        seconds_between(before.time_ns, time_ns) / seconds_between(before.time_ns, after.time_ns);
    const Pose2 odom{std::lerp(before.odom.x, after.odom.x, share),
                     std::lerp(before.odom.y, after.odom.y, share),
                     std::lerp(before.odom.yaw, after.odom.yaw, share)};
    return place_after(before, odom, scaled(after.noise, share), age, 1.0 - share);
  }
  if (!initialises || count_ == ring_ticks) {
    return std::nullopt;
  }
  if (count_ == 0) {
    return Place{newest().odom, newest().covariance};
  }
  const Tick& oldest = ring_[index(count_ - 1)];
  const double dt = seconds_between(oldest.time_ns, time_ns);
  return Place{moved(oldest.odom, velocity_, dt), oldest.covariance, count_ - 1,
               -dt / settings_.period_s};
}

/// Begins at a camera pose, the odometry frame too.
void PoseAnchor::initialise(const Pose2& seen, Place at, const Symmetric3& covariance) noexcept {
  rebase(frame_of(seen, at.odom));
  at.odom = seen;
  re_anchor(at, seen, covariance);
  initialised_ = true;
  reset_count_ = 1;
  last_jump_ = {};
  test_ratio_ = 0.0;
}

/// Puts the map pose at `at` to `map`, and lets its covariance grow from there to the newest tick.
void PoseAnchor::re_anchor(const Place& at, const Pose2& map,
                           const Symmetric3& covariance) noexcept {
  const Pose2 map_before = this->map();
  map_from_odom_ = frame_of(map, at.odom);

  Symmetric3 P = covariance;
  Pose2 from = at.odom;
  double steps = at.steps;
  for (std::size_t age = at.age + 1; age-- > 0;) {
    Tick& tick = ring_[index(age)];
    P = propagated(P, from, tick.odom, map_from_odom_.yaw, scaled(tick.noise, steps));
    tick.covariance = P;
    from = tick.odom;
    steps = 1.0;
  }

  const Pose2 map_after = this->map();
  last_jump_ = {map_after.x - map_before.x, map_after.y - map_before.y,
                map_after.yaw - map_before.yaw};
  ++reset_count_;
  rejected_ = {};
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
