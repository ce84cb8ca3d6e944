#include "estimator/ekf/departure.hpp"

#include <algorithm>
#include <cmath>

#include "estimator/common/pose.hpp"
#include "estimator/common/time.hpp"
#include "estimator/ekf/judge.hpp"
#include "estimator/ekf/standstill.hpp"

namespace odomd::estimator::full {
namespace {

// No car that goes faster [m/s] turns round before it has been heard again that it does.
constexpr double fastest_turn_round = 0.5;
// One that goes faster [m/s] in neutral rolls on as it did.
constexpr double slowest_rolling = 0.1;

}  // namespace

void begin_motion(State& state, const Sample& sample) noexcept {
  const double speed = sample.value[0];
  const double yaw_rate = state.mean[at::yaw_rate];
  const std::int64_t consistent_ns = consistent_since_ns(state, sample);
  const std::int64_t seen_ns = state.fused_ns[index_of(Source::camera)];
  const Pose2 pose = moved(state.pose(), {speed, 0.0, yaw_rate},
                           seconds_between(std::max(consistent_ns, seen_ns), sample.time_ns));
  const double made_up = 0.5 * std::hypot(pose.x - state.mean[at::x], pose.y - state.mean[at::y]);
  state.covariance.diagonal().head<2>().array() += made_up * made_up;
  state.moving = true;
  state.turned_since_ns = 0;
  state.mean.segment<4>(at::x) << pose.x, pose.y, pose.yaw, speed;
  if (seen_ns != 0 && seen_ns < consistent_ns) {
    const double unknown_s = seconds_between(seen_ns, consistent_ns);
    const double way = speed * unknown_s;
    const double turn = yaw_rate * unknown_s;
    state.covariance.diagonal().head<3>() += Eigen::Vector3d(way * way, way * way, turn * turn);
  }
}

bool sets_off(State& state, const Sample& sample, const WheelCount& wheels) noexcept {
  const Reading& before = state.readings[index_of(sample.source)];
  if (wheels.turning > wheels.still) {
    return wheels.turning > 1 ||
           (consistent_samples(state, sample) > 0 &&
            (is_turning(before.value, sample.sigma[0]) ||
             seconds_between(before.time_ns, sample.time_ns) > next_sample_s));
  }
  return rejected_s(state, sample) >= dead_after_s && wheels.turning == wheels.still &&
         (wheels.free_turning || !wheels.free_still);
}

Verdict take_direction(const CarModel& model, State& state, const Sample& sample) noexcept {
  const Reading before = state.readings[index_of(Source::direction)];
  note_reading(state, sample);
  const double way = sample.value[0];
  const double v_x = state.mean[at::v_x];
  if (way == 0.0) {
    if (state.standstill.wheels_still || std::abs(v_x) < slowest_rolling) {
      state.direction = {true, sample.time_ns, way};
    }
    return Verdict::fused;
  }
  const bool turned_round = way * (state.direction.value < 0.0 ? -1.0 : 1.0) < 0.0;
  if (turned_round && state.moving && !state.standstill.standing && way * v_x < 0.0) {
    if (std::abs(v_x) > fastest_turn_round && way * before.value <= 0.0) {
      return Verdict::gated;  // one telegram alone turns no car round
    }
    state.mean.segment<6>(at::v_x) << -v_x, 0.0, state.mean[at::yaw_rate], 0.0, 0.0, 0.0;
    set_off(model, state, 2.0 * v_x);
  }
  state.direction = {true, sample.time_ns, way};
  return Verdict::fused;
}

}  // namespace odomd::estimator::full
