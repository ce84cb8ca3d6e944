// The members of TickFilter. Included only where a model is compiled.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "estimator/baselines/tick_filter.hpp"
#include "estimator/common/admission.hpp"
#include "estimator/common/predecessor.hpp"
#include "estimator/common/time.hpp"

namespace odomd::estimator {

inline constexpr std::int64_t most_ticks_made_up = 200;

/// Δt² G V Gᵀ: what errors of the velocity, white from tick to tick, add in one step.
[[nodiscard]] inline Symmetric3 step_noise(const Symmetric3& velocity_covariance, double yaw,
                                           double dt) noexcept {
  return scaled(rotated(velocity_covariance, std::cos(yaw), std::sin(yaw)), dt * dt);
}

template <Motion M>
TickFilter<M>::TickFilter(M motion, const FilterSettings& settings) noexcept
    : car_(settings.vehicle),
      period_s_(settings.period_s),
      period_ns_(std::llround(settings.period_s * ns_per_second)),
      held_(settings.sigma),
      motion_(std::move(motion)),
      anchor_(settings),
      modes_(settings.camera_timeout_s) {}

template <Motion M>
void TickFilter<M>::set_initial_pose(const Pose2& pose) noexcept {
  if (is_possible(pose)) {
    anchor_.set_pose(pose);
  }
}

template <Motion M>
bool TickFilter<M>::resume(const Estimate& predecessor, double gap_s) noexcept {
  if (!may_resume(predecessor, gap_s)) {
    return false;
  }
  const BodyVelocity velocity = velocity_of(predecessor);
  const Symmetric3& P = predecessor.covariance;
  const Symmetric3 V = velocity_covariance_of(predecessor);
  // The car has most likely gone on as it went.
  const Pose2 map = moved(predecessor.map, velocity, gap_s);
  const Pose2 odom = moved(predecessor.odom, velocity, gap_s);
  const double steps = gap_s / period_s_;
  const Symmetric3 grown =
      sum(sum(displaced(P, map.x - predecessor.map.x, map.y - predecessor.map.y),
              scaled(step_noise(V, predecessor.map.yaw, period_s_), steps)),
          gap_noise(gap_s));
  anchor_.resume(map, odom, grown, predecessor.reset_count + 1);
  motion_.resume(velocity, V);
  resumed_speed_ = AxleSpeed{predecessor.v_x, std::sqrt(V[0])};
  running_ = false;
  return true;
}

template <Motion M>
Verdict TickFilter<M>::add(const Measurement& sample) noexcept {
  const Verdict verdict = held_.take(sample, latest_ns(sample.arrival_ns));
  // What the model does not use is held all the same: it is published.
  return verdict == Verdict::fused && !M::uses(sample.source) ? Verdict::source_off : verdict;
}

template <Motion M>
Verdict TickFilter<M>::add(const CameraPose& camera) noexcept {
  if (motion_.stopped()) {
    return Verdict::source_off;
  }
  return anchor_.take(camera, latest_ns(camera.arrival_ns), next_tick_ns());
}

template <Motion M>
Estimate TickFilter<M>::step(std::int64_t tick_ns) noexcept {
  // 1. How many ticks are due. Half a period off the grid is still the same tick.
  std::int64_t due = 1;
  if (last_tick_ns_) {
    const std::int64_t elapsed = ns_between(*last_tick_ns_, tick_ns);
    due =
        elapsed <= 0 ? 0 : elapsed / period_ns_ + (elapsed % period_ns_ >= period_ns_ / 2 ? 1 : 0);
  }
  if (due <= 0) {
    return last_;
  }
  const std::int64_t steps = std::min(due, most_ticks_made_up);
  const double unobserved_s = static_cast<double>(due - steps) * period_s_;

  // 2. The speed, from whichever wheels there are.
  const std::optional<AxleSpeed> speed = wheel_speed();
  if (speed && !running_) {
    running_ = true;
    anchor_.start(ns_after(tick_ns, -steps * period_ns_));
  }

  // 3. The motion, a period at a time.
  if (speed) {
    for (std::int64_t left = steps; left-- > 0;) {
      advance(*speed, ns_after(tick_ns, -left * period_ns_),
              left == steps - 1 ? unobserved_s : 0.0);
    }
  }

  // 4. What is believed now.
  last_tick_ns_ = tick_ns;
  last_ = estimate(tick_ns, speed ? speed->v_x : 0.0);
  return last_;
}

template <Motion M>
void TickFilter<M>::advance(const AxleSpeed& speed, std::int64_t tick_ns,
                            double gap_before_s) noexcept {
  const M good = motion_;
  const Pose2 before = anchor_.odom();
  Pose2 odom = before;
  motion_.advance(held_, speed, odom);
  Symmetric3 noise = step_noise(motion_.velocity_covariance(), before.yaw, period_s_);
  if (!motion_.finite() || !is_finite(odom) || !is_finite(noise)) {
    motion_ = good;
    odom = before;
    noise = step_noise(motion_.velocity_covariance(), before.yaw, period_s_);
    ++recoveries_;
  }
  if (gap_before_s > 0.0) {
    noise = sum(noise, gap_noise(gap_before_s));
  }
  anchor_.extend(tick_ns, odom, noise, motion_.velocity());
}

template <Motion M>
Estimate TickFilter<M>::estimate(std::int64_t tick_ns, double wheel_speed) noexcept {
  Estimate e;
  e.time_ns = tick_ns;
  e.initialised = running_ && anchor_.initialised();
  e.model_fault = motion_.stopped();

  e.map = anchor_.map();
  e.odom = anchor_.odom();
  e.covariance = anchor_.covariance();
  e.reset_count = anchor_.reset_count();
  e.last_jump = anchor_.last_jump();
  e.camera_ns = anchor_.camera_ns();
  e.camera_test_ratio = anchor_.test_ratio();

  const BodyVelocity velocity = motion_.velocity();
  e.v_x = velocity.v_x;
  e.v_y = velocity.v_y;
  e.yaw_rate = velocity.yaw_rate;
  e.velocity_covariance = motion_.velocity_covariance();

  e.accel_x = held_.value(Source::accel_x);
  e.accel_y = held_.value(Source::accel_y);
  e.steering = held_.value(Source::steering);
  e.recoveries = recoveries_;

  e.mode = modes_.update({.time_ns = tick_ns,
                          .initialised = e.initialised,
                          .fault = e.model_fault,
                          .wheel_speed = wheel_speed,
                          .yaw_rate = e.yaw_rate,
                          .camera_ns = e.camera_ns});
  // A car that stands does not accelerate, whatever the bias of its sensors says.
  if (e.mode != Mode::standstill) {
    const BodyVelocity rate = motion_.acceleration(held_);
    e.v_x_dot = rate.v_x;
    e.v_y_dot = rate.v_y;
    e.yaw_accel = rate.yaw_rate;
  }
  return e;
}

template <Motion M>
std::int64_t TickFilter<M>::next_tick_ns() const noexcept {
  return last_tick_ns_ ? ns_after(*last_tick_ns_, period_ns_)
                       : std::numeric_limits<std::int64_t>::max();
}

template <Motion M>
std::int64_t TickFilter<M>::latest_ns(std::int64_t arrival_ns) const noexcept {
  return ns_after(arrival_ns != 0 ? arrival_ns : next_tick_ns(), period_ns_);
}

template <Motion M>
std::optional<AxleSpeed> TickFilter<M>::wheel_speed() const noexcept {
  const std::optional<AxleSpeed> heard =
      rear_axle_speed(car_, held_, motion_.yaw_rate_at_wheels(held_));
  return heard ? heard : resumed_speed_;
}

}  // namespace odomd::estimator
