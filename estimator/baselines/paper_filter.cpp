#include "estimator/baselines/paper_filter.hpp"

#include "estimator/baselines/tick_filter_impl.hpp"
#include "estimator/common/dynamic_model.hpp"

namespace odomd::estimator {

PaperMotion::PaperMotion(const FilterSettings& settings) noexcept
    : ekf_{.car = settings.vehicle, .noise = settings.paper, .dt = settings.period_s} {}

void PaperMotion::advance(const HeldSignals& held, const AxleSpeed& speed, Pose2& odom) noexcept {
  if (stopped_) {
    return;
  }
  predict(ekf_, {held.value(Source::steering), held.value(Source::accel_x)});
  correct(ekf_, {held.value(Source::yaw_rate), speed.v_x});
  if (ekf_.x[0] < slowest_v_x) {
    stopped_ = true;
    ekf_.x.setZero();
    return;
  }
  odom = moved_euler(odom, velocity(), ekf_.dt);
}

void PaperMotion::resume(const BodyVelocity& velocity, const Symmetric3& covariance) noexcept {
  ekf_.x << velocity.v_x, velocity.v_y, velocity.yaw_rate;
  ekf_.P = covariance;
}

BodyVelocity PaperMotion::acceleration(const HeldSignals& held) const noexcept {
  if (stopped_) {
    return {};
  }
  const Eigen::Vector3d rate = dynamic_rate<double>(
      ekf_.car, ekf_.x, {held.value(Source::steering), held.value(Source::accel_x)},
      slowest_resolved_speed(ekf_.car, ekf_.dt));
  return {rate[0], rate[1], rate[2]};
}

template class TickFilter<PaperMotion>;

}  // namespace odomd::estimator
