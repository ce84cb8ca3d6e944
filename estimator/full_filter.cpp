#include "estimator/full_filter.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "estimator/common/pose.hpp"
#include "estimator/common/predecessor.hpp"
#include "estimator/common/time.hpp"
#include "estimator/ekf/judge.hpp"
#include "estimator/ekf/publication.hpp"
#include "estimator/ekf/take.hpp"
#include "estimator/ekf/update.hpp"
#include "estimator/integrity/admission.hpp"

namespace odomd::estimator {

using full::Sample;
using full::State;
namespace at = full::at;

FullFilter::FullFilter(const FilterSettings& settings) noexcept
    : context_{.model = {{settings.vehicle, settings.tuning}, settings.imu_position},
               .camera = {settings.camera_gate, settings.initialise_from_camera},
               .period_s = settings.period_s},
      sigma_(settings.sigma),
      initial_(full::initial_state(settings)),
      period_ns_(std::llround(settings.period_s * ns_per_second)),
      window_ns_(std::llround(settings.window_s * ns_per_second)),
      reach_ns_(window_ns_ + window_ns_ / 2),
      camera_latency_ns_(std::llround(settings.camera_max_latency_s * ns_per_second)),
      steering_delay_ns_(std::llround(settings.vehicle.steering.delay_s * ns_per_second)),
      latencies_(window_ns_) {
  context_.model.gyro_sigma = sigma_[index_of(Source::yaw_rate)];
  history_.restart() = initial_;
  latencies_.begin(initial_);
}

void FullFilter::set_initial_pose(const Pose2& pose) noexcept {
  if (!is_possible(pose)) {
    return;
  }
  // A replay must not cross the new pose.
  State& now = history_.restart();
  const Pose2 before = now.pose();
  now.mean.segment<3>(at::x) << pose.x, pose.y, pose.yaw;
  now.turned_since_ns = 0;
  now.lasting_way = {};
  now.lasting_turn = {};
  now.disputed.setZero();
  now.doubtful = now.unconfirmed = false;
  now.camera_evidence = 0.0;
  now.last_camera_pose = {};
  for (const at::Index index : {at::x, at::y, at::yaw}) {
    full::forget(now, index, std::sqrt(initial_.variance(index)));
  }
  if (!std::exchange(now.located, true)) {
    odom_ = pose;
    reset_count_ = 1;
    return;
  }
  ++reset_count_;
  last_jump_ = pose - before;
}

std::optional<Verdict> FullFilter::add(const Measurement& sample) noexcept {
  if (const std::optional<Verdict> refused = refusal(sample)) {
    return refused;
  }
  const std::size_t index = index_of(sample.source);
  const double sigma = sample.sigma > 0.0 ? sample.sigma : sigma_[index];
  // Moves a command later (actuator delay), or a late sample earlier, at most to the oldest state.
  const std::int64_t actuator_ns = sample.source == Source::steering ? steering_delay_ns_ : 0;
  const std::int64_t time_ns = ns_after(sample.time_ns, actuator_ns);
  const std::int64_t room_ns = std::max<std::int64_t>(ns_between(history_.oldest_ns(), time_ns), 1);
  const std::int64_t advance_ns =
      std::min(latencies_.advance_ns(sample.source, time_ns), room_ns - 1);
  const std::int64_t delay_ns = actuator_ns - advance_ns;
  return insert({.time_ns = ns_after(sample.time_ns, delay_ns),
                 .source = sample.source,
                 .value = {sample.value},
                 .sigma = {bounded_sigma(sigma, physical_limit[index])},
                 .advanced_s = static_cast<double>(advance_ns) * seconds_per_ns},
                sample.arrival_ns, delay_ns);
}

std::optional<Verdict> FullFilter::add(const CameraPose& camera) noexcept {
  if (!is_usable(camera)) {
    return Verdict::non_finite;
  }
  if (std::abs(camera.x) > largest_coordinate || std::abs(camera.y) > largest_coordinate) {
    return Verdict::gated;
  }
  if (camera.arrival_ns != 0 &&
      ns_between(camera.capture_ns, camera.arrival_ns) > camera_latency_ns_) {
    return Verdict::too_old;
  }
  camera_clock_.add(camera.capture_ns, camera.arrival_ns);
  const auto bounded = [](double sigma) { return bounded_sigma(sigma, largest_camera_sigma); };
  return insert(
      {.time_ns = camera.capture_ns,
       .source = Source::camera,
       .value = {camera.x, camera.y, wrap_angle(camera.yaw)},
       .sigma = {bounded(camera.sigma_x), bounded(camera.sigma_y), bounded(camera.sigma_yaw)}},
      camera.arrival_ns, 0);
}

std::optional<Verdict> FullFilter::insert(const Sample& sample, std::int64_t arrival_ns,
                                          std::int64_t delay_ns) noexcept {
  const std::int64_t latest_ns = arrival_of(arrival_ns, last_tick_ns_, period_ns_);
  if (sample.time_ns > ns_after(latest_ns, period_ns_ + delay_ns)) {
    return Verdict::future;
  }
  if (last_tick_ns_ &&
      (ns_after(sample.time_ns, std::llround(sample.advanced_s * ns_per_second)) <=
           ns_after(*last_tick_ns_, -window_ns_) ||
       sample.time_ns <= std::max(window_.dropped_until_ns(), history_.oldest_ns()))) {
    return Verdict::too_old;
  }
  const full::Insertion insertion = window_.insert(sample);
  if (insertion == full::Insertion::dropped) {
    return Verdict::too_old;
  }
  if (insertion != full::Insertion::duplicate) {
    oldest_new_sample_ns_ = std::min(oldest_new_sample_ns_, sample.time_ns);
  }
  return insertion == full::Insertion::inserted ? std::nullopt : std::optional(Verdict::duplicate);
}

Estimate FullFilter::step(std::int64_t tick_ns) noexcept {
  judgements_.clear();
  if (!last_tick_ns_) {
    begin(tick_ns);
  } else if (ns_between(*last_tick_ns_, tick_ns) < period_ns_ / 2) {
    return last_;
  }
  const bool located_before = history_.now().located;

  // 1. Rewind to the oldest new sample, and replay from there.
  const BodyVelocity published = history_.now().velocity();
  const Pose2 odom_before = odom_;
  history_.rewind_to(
      std::exchange(oldest_new_sample_ns_, std::numeric_limits<std::int64_t>::max()));
  replay_to(tick_ns, published);
  if (!full::is_valid(history_.now())) {
    odom_ = odom_before;
    recover(tick_ns);
  }

  const State& now = history_.now();
  if (now.located && !located_before) {
    reset_count_ = 1;
  }
  // 2. The odometry frame starts at the first pose published in the map frame.
  if (!odom_begun_) {
    odom_ = now.pose();
    odom_begun_ = now.located && now.moving;
  }
  count_resets();

  last_tick_ns_ = tick_ns;
  judgements_.report_dropped(window_);
  // 3. Drop samples that are too old for a replay, or from the future.
  const std::int64_t oldest_ns = std::min(ns_after(tick_ns, -reach_ns_), history_.oldest_ns());
  judgements_.refuse(window_.until(oldest_ns), Verdict::too_old);
  window_.forget_until(oldest_ns);
  const std::int64_t newest_ns = ns_after(tick_ns, period_ns_ + steering_delay_ns_);
  judgements_.refuse(window_.after(newest_ns), Verdict::future);
  window_.forget_after(newest_ns);
  last_ = estimate(tick_ns);
  return last_;
}

/// The first tick: the state starts `reach_ns_` earlier, so that earlier samples count. A resumed
/// state is at the tick before.
void FullFilter::begin(std::int64_t tick_ns) noexcept {
  State& now = history_.restart();
  now.time_ns = ns_after(tick_ns, now.moving ? -period_ns_ : -reach_ns_ - period_ns_);
  last_tick_ns_ = now.time_ns;
}

/// Counts the camera's resets of the published pose. If a replay undoes a reset, that is one more
/// jump; if late samples only change the length of a reset, it is the same jump.
void FullFilter::count_resets() noexcept {
  const State& now = history_.now();
  const Pose2& jump = now.last_jump;
  if (now.resets > published_resets_) {
    ++reset_count_;
    last_jump_ = jump;
  } else if (now.resets < published_resets_) {
    ++reset_count_;
    last_jump_ = Pose2() - published_jump_;
  } else if (difference(jump, published_jump_) != std::array<double, 3>{}) {
    last_jump_ = jump;
  }
  published_resets_ = now.resets;
  published_jump_ = jump;
}

/// Applies the samples after the state up to `tick_ns`, tick by tick. The odometry integrates the
/// published velocities, beginning with `velocity`.
void FullFilter::replay_to(std::int64_t tick_ns, BodyVelocity velocity) noexcept {
  const std::int64_t behind = ns_between(history_.now().time_ns, tick_ns);
  std::int64_t ticks = behind / period_ns_ + (behind % period_ns_ >= period_ns_ / 2 ? 1 : 0);
  if (ticks > max_bridged_ticks + reach_ns_ / period_ns_) {
    ticks = max_bridged_ticks;
    State& now = history_.restart();
    last_tick_ns_ = ns_after(tick_ns, -ticks * period_ns_);
    full::bridge_gap(now, seconds_between(now.time_ns, *last_tick_ns_));
    now.time_ns = *last_tick_ns_;
    latencies_.begin(now);
  }
  std::span<Sample> samples = window_.after(history_.now().time_ns);
  for (std::int64_t left = ticks; left-- > 0;) {
    const std::int64_t grid_ns = ns_after(tick_ns, -left * period_ns_);
    State& now = history_.writable();
    const std::int64_t before_ns = now.time_ns;
    for (; !samples.empty() && samples.front().time_ns <= grid_ns; samples = samples.subspan(1)) {
      Sample& sample = samples.front();
      full::advance(context_, now, sample.time_ns);
      Judgement judgement = full::take(context_, now, sample);
      judgement.time_ns = sample.time_ns;
      if (!std::exchange(sample.judged, true)) {
        judgements_.report(judgement);
      }
    }
    full::advance(context_, now, grid_ns);
    full::apply_integrity(context_, now);
    full::limit(now);
    latencies_.note(now, before_ns);
    if (now.moving && grid_ns > *last_tick_ns_) {
      const BodyVelocity next = now.velocity();
      const BodyVelocity mean{0.5 * (velocity.v_x + next.v_x), 0.5 * (velocity.v_y + next.v_y),
                              0.5 * (velocity.yaw_rate + next.yaw_rate)};
      odom_ = moved(odom_, mean, seconds_between(*last_tick_ns_, grid_ns));
      velocity = next;
      last_tick_ns_ = grid_ns;
    }
    history_.keep(reach_ns_);
  }
}

/// Restarts an invalid state at the last published pose, or at the odometry's pose if there is
/// none. The old velocity was probably wrong, so the new one is uncertain until the wheels measure
/// it.
void FullFilter::recover(std::int64_t tick_ns) noexcept {
  ++recoveries_;
  State& now = history_.restart();
  const auto [located, moving] = std::pair(now.located, now.moving);
  now = initial_;
  now.time_ns = tick_ns;
  now.located = located;
  now.moving = moving;
  now.resets = published_resets_;
  now.last_jump = published_jump_;
  now.doubtful = true;
  const Pose2 pose = last_.initialised ? last_.map : odom_;
  now.mean.segment<3>(at::x) << pose.x, pose.y, pose.yaw;
  if (may_resume(last_, 0.0)) {
    now.covariance.topLeftCorner<3, 3>() += unpacked(last_.covariance);
  }
  now.variance(at::v_x) += last_.v_x * last_.v_x;
  latencies_.begin(now);
}

bool FullFilter::resume(const Estimate& predecessor, double gap_s) noexcept {
  if (!may_resume(predecessor, gap_s)) {
    return false;
  }
  State& now = history_.restart();
  const std::int64_t time_ns = now.time_ns;
  now = full::resumed(context_.model, predecessor, gap_s, initial_);
  now.time_ns = time_ns;
  latencies_.begin(now);
  published_resets_ = now.resets;
  published_jump_ = now.last_jump;
  odom_begun_ = true;
  odom_ = moved(predecessor.odom, velocity_of(predecessor), gap_s);
  reset_count_ = predecessor.reset_count + 1;
  last_jump_ = {};
  return true;
}

SourceNoise FullFilter::noise(Source source) const noexcept {
  return full::noise_of(context_.model.tuning, history_.now(), source, sigma_[index_of(source)]);
}

Estimate FullFilter::estimate(std::int64_t tick_ns) noexcept {
  const State& now = history_.now();
  Estimate e =
      full::publication(context_.model, full::input_of(now), context_.period_s, now, initial_);
  e.time_ns = tick_ns;
  e.odom = odom_;
  e.reset_count = reset_count_;
  e.last_jump = last_jump_;
  e.recoveries = recoveries_;
  e.doubtful = now.doubtful || now.integrity.agreed().camera_inconsistent || camera_clock_.drifts();
  e.mode = modes_.update(e, now.standstill.standing);
  return e;
}

}  // namespace odomd::estimator
