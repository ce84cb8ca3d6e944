#include "estimator/integrity/judge.hpp"

#include <algorithm>
#include <cmath>

#include "estimator/common/time.hpp"
#include "estimator/integrity/plausibility.hpp"
#include "estimator/integrity/standstill.hpp"

namespace odomd::estimator::full {
namespace {

// A car that slides on locked wheels slows down at least so much, and its accelerometer feels it.
constexpr double slide_slows = 1.0;  // [m/s²]

/// Until when the filter had one of the same kind to go by: wheels that are outvoted by those that
/// are rejected count no longer.
std::int64_t vouched_until_ns(const State& state, const Sample& sample) noexcept {
  const bool outvoted = is_wheel(sample.source) && outvotes_the_fused(state, sample);
  return outvoted ? state.fused_ns[index_of(sample.source)] : last_fused_ns(state, sample.source);
}

struct Patience {
  double seconds;
  at::Index doubted;  ///< the state that gives way
};

/// So fast the tyres would pull ψ̇ back to where the model wants it [s].
constexpr double yaw_settling_s = 0.05;

/// Of a car that stands nothing moves: there, it is the sensor's bias that has changed.
Patience patience_with(Source source, const Prediction& prediction, bool standing) noexcept {
  switch (source) {
    case Source::yaw_rate:
      return {0.05, standing ? at::gyro_bias : at::yaw_rate};
    case Source::accel_y:
      // Of a slow car, too, nothing but the bias explains it.
      return {0.2, prediction.count() == 1 ? at::accel_bias_y : at::front_force};
    case Source::accel_x:
      // Standing; but a car whose wheels are blind to slow speeds sets off like this.
      return {1.5, at::accel_bias_x};
    default:
      return {0.25, at::v_x};
  }
}

/// Whether wheels that have read zero for as long as they were rejected are locked.
bool slides(const State& state, const Sample& sample) noexcept {
  const Rejection& rejection = state.rejected[index_of(sample.source)];
  const double elapsed_s = seconds_between(rejection.since_ns, sample.time_ns);
  return is_wheel(sample.source) && !turns(sample.value[0], sample.sigma[0]) &&
         std::abs(rejection.speed) - std::abs(state.mean[at::v_x]) >= slide_slows * elapsed_s;
}

}  // namespace

std::int64_t last_fused_ns(const State& state, Source source) noexcept {
  if (!is_wheel(source)) {
    return state.fused_ns[index_of(source)];
  }
  return last_wheel_ns(state);
}

Judgement judge(double gate, State& state, const Sample& sample, const Prediction& prediction,
                Teaches teaches) noexcept {
  Innovation nu = innovation(state, prediction, sample.value[0]);
  Judgement judgement{.source = sample.source, .verdict = Verdict::fused, .degrees = 1};
  judgement.innovation[0] = nu.value;
  judgement.variance[0] = nu.variance;
  judgement.squared_ratio = nu.squared_ratio();
  judgement.test_ratio = judgement.squared_ratio / gate;

  Rejection& rejection = state.rejected[index_of(sample.source)];
  if (!(judgement.squared_ratio <= gate)) {
    judgement.verdict = Verdict::gated;
    count_rejected(state, sample, nu.value);
    const Patience patience = patience_with(sample.source, prediction, state.rest.standing);
    if (!insists(state, sample, vouched_until_ns(state, sample), patience.seconds)) {
      return judgement;
    }
    if (slides(state, sample)) {
      rejection = {};
      return judgement;
    }
    judgement.verdict = Verdict::fused;
    state.covariance(patience.doubted, patience.doubted) += nu.value * nu.value;
    if (patience.doubted == at::yaw_rate) {
      // What turns the car is not what the model says, or ψ̇ would not stay.
      const double moment = nu.value / yaw_settling_s;
      state.covariance(at::yaw_moment, at::yaw_moment) += moment * moment;
    }
    nu = innovation(state, prediction, sample.value[0]);
  }
  rejection = {};
  std::int64_t& fused_ns = state.fused_ns[index_of(sample.source)];
  const double unheard_s =
      fused_ns == 0 ? 0.0 : std::min(seconds_between(fused_ns, sample.time_ns), longest_unheard_s);
  fused_ns = sample.time_ns;
  correct(state, nu, gain_of_own_sensors(state, nu, unheard_s, teaches));
  return judgement;
}

}  // namespace odomd::estimator::full
