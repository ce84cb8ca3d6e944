// The paper's filter as its author runs it: each tick one predict and one correct with the newest
// value of each signal, held, whatever its time; then X, Y and ψ from the corrected state.
#pragma once

#include "estimator/baselines/held_signals.hpp"
#include "estimator/baselines/paper_ekf.hpp"
#include "estimator/baselines/tick_filter.hpp"
#include "estimator/baselines/wheel_speed.hpp"
#include "estimator/common/pose.hpp"
#include "estimator/common/settings.hpp"
#include "estimator/common/symmetric3.hpp"

namespace odomd::estimator {

/// Starts at x = 0, P = I, and moves already in its first tick. A signal that was not seen yet
/// counts as 0.
class PaperMotion {
 public:
  /// Below this v_x [m/s] the discrete model is about to lose its stability: it stops for good.
  static constexpr double slowest_v_x = -0.05;

  explicit PaperMotion(const FilterSettings& settings) noexcept;

  [[nodiscard]] static bool uses(Source source) noexcept { return source != Source::accel_y; }
  [[nodiscard]] static double yaw_rate_at_wheels(const HeldSignals& held) noexcept {
    return held.value(Source::yaw_rate);
  }
  void advance(const HeldSignals& held, const AxleSpeed& speed, Pose2& odom) noexcept;
  void resume(const BodyVelocity& velocity, const Symmetric3& covariance) noexcept;

  [[nodiscard]] BodyVelocity velocity() const noexcept { return {ekf_.x[0], ekf_.x[1], ekf_.x[2]}; }
  [[nodiscard]] Symmetric3 velocity_covariance() const noexcept { return ekf_.P; }
  [[nodiscard]] BodyVelocity acceleration(const HeldSignals& held) const noexcept;
  [[nodiscard]] bool stopped() const noexcept { return stopped_; }
  [[nodiscard]] bool finite() const noexcept { return is_finite(velocity()) && is_finite(ekf_.P); }

 private:
  PaperEkf ekf_;
  bool stopped_ = false;
};

extern template class TickFilter<PaperMotion>;
using PaperFilter = TickFilter<PaperMotion>;

}  // namespace odomd::estimator
