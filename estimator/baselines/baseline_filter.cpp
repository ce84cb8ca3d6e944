#include "estimator/baselines/baseline_filter.hpp"

#include <algorithm>
#include <cmath>

#include "estimator/common/predecessor.hpp"
#include "estimator/common/time.hpp"
#include "estimator/integrity/admission.hpp"

namespace odomd::estimator {

BaselineFilter::BaselineFilter(Model model, const FilterSettings& settings) noexcept
    : model_(model),
      settings_(settings),
      period_ns_(std::llround(settings.period_s * ns_per_second)),
      held_(settings),
      gyro_bias_(settings.tuning),
      anchor_(settings) {}

void BaselineFilter::set_initial_pose(const Pose2& pose) noexcept {
  if (is_possible(pose)) {
    anchor_.set_pose(pose);
  }
}

bool BaselineFilter::resume(const Estimate& predecessor, double gap_s) noexcept {
  if (!may_resume(predecessor, gap_s)) {
    return false;
  }
  const Estimate now = after_gap(predecessor, gap_s);
  anchor_.resume(now);
  motion_.velocity = velocity_of(now);
  motion_.covariance = now.velocity_covariance;
  motion_.moving = true;
  speed_ = AxleSpeed{now.v_x, std::sqrt(now.velocity_covariance[0])};
  return true;
}

Verdict BaselineFilter::add(const Measurement& sample) noexcept {
  const std::int64_t arrival_ns = arrival_of(sample.arrival_ns, last_tick_ns_, period_ns_);
  const Verdict verdict = held_.take(sample, ns_after(arrival_ns, period_ns_));
  if (verdict == Verdict::fused) {
    const bool reverse = is_wheel(sample.source) && held_[Source::direction].value < 0.0;
    integrity_.add(sample.source, sample.time_ns, reverse ? -std::abs(sample.value) : sample.value,
                   held_[sample.source].sigma, sample.arrival_ns);
    if (model_ == Model::inertial && sample.source == Source::yaw_rate) {
      gyro_bias_.add(held_[Source::yaw_rate], held_.wheels_still());
    }
  }
  const bool used =
      sample.source != Source::accel_y && (sample.source != Source::yaw_rate || uses_gyro(model_));
  // Signals that the model does not use are also held, because they are published.
  return verdict == Verdict::fused && !used ? Verdict::source_off : verdict;
}

Verdict BaselineFilter::add(const CameraPose& camera) noexcept {
  if (motion_.stopped) {
    return Verdict::source_off;
  }
  const std::int64_t arrival_ns = arrival_of(camera.arrival_ns, last_tick_ns_, period_ns_);
  const Verdict verdict = anchor_.take(camera, ns_after(arrival_ns, period_ns_), arrival_ns);
  if (verdict == Verdict::fused || verdict == Verdict::gated) {
    integrity_.add(camera);
  }
  return verdict;
}

Estimate BaselineFilter::step(std::int64_t tick_ns) noexcept {
  // 1. Number of ticks to step through: 0 if the last tick is less than half a period ago.
  const std::int64_t elapsed = last_tick_ns_ ? ns_between(*last_tick_ns_, tick_ns) : period_ns_;
  if (elapsed < period_ns_ / 2) {
    return last_;
  }
  const std::int64_t due = elapsed / period_ns_ + (elapsed % period_ns_ >= period_ns_ / 2 ? 1 : 0);

  // 2. The speed from the available wheels, and the motion, one period at a time.
  const double yaw_rate = uses_gyro(model_) ? held_[Source::yaw_rate].value - gyro_bias_.value()
                                            : motion_.velocity.yaw_rate;
  if (const auto measured = rear_axle_speed(settings_.vehicle, held_, yaw_rate)) {
    speed_ = measured;
  }
  if (speed_) {
    for (std::int64_t left = std::min(due, max_bridged_ticks); left-- > 0;) {
      advance(ns_after(tick_ns, -left * period_ns_));
    }
  }

  // 3. Integrity and the estimate.
  integrity_.check({settings_.vehicle, settings_.tuning}, tick_ns);
  last_tick_ns_ = tick_ns;
  last_ = estimate(tick_ns);
  return last_;
}

/// Advances by one period. Discards the step if its result is not finite.
void BaselineFilter::advance(std::int64_t tick_ns) noexcept {
  Motion next = motion_;
  model_ == Model::paper
      ? advance_paper(settings_, held_, *speed_, next)
      : advance_dead_reckoning(model_, settings_, held_, gyro_bias_, *speed_, next);
  if (is_finite(next.way) && is_finite(next.velocity) && is_finite(next.covariance)) {
    motion_ = next;
  } else {
    motion_.way = {};
    ++recoveries_;
  }
  anchor_.extend(tick_ns, motion_);
}

Estimate BaselineFilter::estimate(std::int64_t tick_ns) noexcept {
  Estimate e;
  e.time_ns = tick_ns;
  e.initialised = anchor_.started() && anchor_.initialised();
  e.model_fault = motion_.stopped;

  e.map = anchor_.map();
  e.odom = anchor_.odom();
  e.covariance = anchor_.covariance();
  e.reset_count = anchor_.reset_count();
  e.last_jump = anchor_.last_jump();
  e.camera_ns = anchor_.camera_ns();
  e.camera_test_ratio = anchor_.test_ratio();

  e.v_x = motion_.velocity.v_x;
  e.v_y = motion_.velocity.v_y;
  e.yaw_rate = motion_.velocity.yaw_rate;
  e.velocity_covariance =
      packed(unpacked(motion_.covariance) + by_errors(motion_.sensitivity, motion_.error_variance));

  e.accel_x = held_[Source::accel_x].value;
  e.accel_y = held_[Source::accel_y].value;
  e.steering = held_[Source::steering].value;
  e.recoveries = recoveries_;

  e.mode = modes_.update(e, modes_.is_still(speed_ ? speed_->v_x : 0.0, e.yaw_rate));
  // A stationary car does not accelerate, whatever the sensors' bias.
  if (e.mode != Mode::standstill) {
    e.v_x_dot = motion_.rate.v_x;
    e.v_y_dot = motion_.rate.v_y;
    e.yaw_accel = motion_.rate.yaw_rate;
  }
  return e;
}

}  // namespace odomd::estimator
