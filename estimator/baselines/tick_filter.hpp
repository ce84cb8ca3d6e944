// What the models without a window of late samples share: the newest value of each signal held, one
// step of the motion a tick, the anchor for the camera, the mode. The model itself is `Motion`.
//
// A value; no heap, no clock. Members are defined in tick_filter_impl.hpp, and compiled once per
// model in <model>_filter.cpp.
#pragma once

#include <concepts>
#include <cstdint>
#include <limits>
#include <optional>

#include "estimator/baselines/held_signals.hpp"
#include "estimator/baselines/pose_anchor.hpp"
#include "estimator/baselines/wheel_speed.hpp"
#include "estimator/common/estimate.hpp"
#include "estimator/common/measurement.hpp"
#include "estimator/common/mode_monitor.hpp"
#include "estimator/common/pose.hpp"
#include "estimator/common/settings.hpp"
#include "estimator/common/symmetric3.hpp"

namespace odomd::estimator {

/// A model of the car that is stepped with the inputs held. Copying one must be cheap: the last
/// good one is kept.
template <typename M>
concept Motion = std::copyable<M> && requires(M motion, const M& state, const HeldSignals& held,
                                              const AxleSpeed& speed, Pose2& odom) {
  // Which sources it listens to; samples of others get the verdict source_off.
  requires std::same_as<decltype(M::uses(Source::yaw_rate)), bool>;
  // The yaw rate with which a single wheel's speed is taken to the middle of the axle.
  requires std::same_as<decltype(state.yaw_rate_at_wheels(held)), double>;
  // One period: its own state, and the odometry pose with it.
  motion.advance(held, speed, odom);
  // Starts from a predecessor's velocity instead of its own beginning.
  motion.resume(BodyVelocity{}, Symmetric3{});
  requires std::same_as<decltype(state.velocity()), BodyVelocity>;
  requires std::same_as<decltype(state.velocity_covariance()), Symmetric3>;
  // (v̇_x, v̇_y, ψ̈) at the state.
  requires std::same_as<decltype(state.acceleration(held)), BodyVelocity>;
  // It has left its domain: the pose stays where it is, for good.
  requires std::same_as<decltype(state.stopped()), bool>;
  requires std::same_as<decltype(state.finite()), bool>;
};

template <Motion M>
class TickFilter {
 public:
  TickFilter(M motion, const FilterSettings& settings) noexcept;

  void set_initial_pose(const Pose2& pose) noexcept;
  bool resume(const Estimate& predecessor, double gap_s) noexcept;
  Verdict add(const Measurement& sample) noexcept;
  Verdict add(const CameraPose& camera) noexcept;
  Estimate step(std::int64_t tick_ns) noexcept;

  [[nodiscard]] const M& motion() const noexcept { return motion_; }

 private:
  [[nodiscard]] std::int64_t next_tick_ns() const noexcept;
  [[nodiscard]] std::int64_t latest_ns(std::int64_t arrival_ns) const noexcept;
  [[nodiscard]] std::optional<AxleSpeed> wheel_speed() const noexcept;
  void advance(const AxleSpeed& speed, std::int64_t tick_ns, double gap_before_s) noexcept;
  [[nodiscard]] Estimate estimate(std::int64_t tick_ns, double wheel_speed) noexcept;

  Vehicle car_;
  double period_s_ = 0.005;
  std::int64_t period_ns_ = 5'000'000;

  HeldSignals held_;
  M motion_;
  PoseAnchor anchor_;
  ModeMonitor modes_;

  std::optional<AxleSpeed> resumed_speed_;  ///< until a wheel is heard
  std::optional<std::int64_t> last_tick_ns_;
  bool running_ = false;  ///< a wheel speed was there, so the motion is being followed
  std::uint32_t recoveries_ = 0;
  Estimate last_;
};

}  // namespace odomd::estimator
