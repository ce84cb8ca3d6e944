#include "estimator/ekf/judge.hpp"

#include <algorithm>
#include <cmath>

#include "estimator/common/time.hpp"
#include "estimator/ekf/noise.hpp"
#include "estimator/ekf/plausibility.hpp"
#include "estimator/ekf/standstill.hpp"

namespace odomd::estimator::full {
namespace {

struct RejectionTimeout {
  double seconds;
  at::Index inflated;  ///< the state that gives way
};

RejectionTimeout rejection_timeout(Source source) noexcept {
  switch (source) {
    case Source::yaw_rate:
      return {0.05, at::yaw_rate};
    case Source::accel_y:
      return {0.2, at::accel_bias_y};
    case Source::accel_x:
      // Standing; but a car whose wheels are blind to slow speeds sets off like this.
      return {1.5, at::accel_bias_x};
    default:
      return {0.1, at::v_x};
  }
}

/// How far a sample may be off without being an outlier, beyond S, however calmly the car went: a
/// gyro by as much as tyres turn a car in since it was last believed, an accelerometer by a pedal,
/// and where there is none a wheel by what that makes of the speed.
double possible_change(const CarModel& model, const State& state, const Sample& sample) noexcept {
  if (state.standstill.standing) {
    return 0.0;
  }
  const auto since_s = [&](std::int64_t time_ns) {
    return std::min(seconds_between(time_ns, sample.time_ns), longest_gap_s);
  };
  const std::int64_t fused_ns = last_fused_ns(state, sample.source);
  if (sample.source == Source::yaw_rate) {
    return model.tuning.turn_in * gravity / model.car.wheelbase() * since_s(fused_ns);
  }
  if (sample.source == Source::accel_x) {
    return model.tuning.pedal * gravity;
  }
  const bool accel_alive = state.accel_x.seen && since_s(state.accel_x.time_ns) < longest_gap_s;
  return is_wheel(sample.source) && !accel_alive ? model.tuning.pedal * gravity * since_s(fused_ns)
                                                 : 0.0;
}

/// What the driver has changed so suddenly that S does not explain it is a change of a_x, and of
/// what it has made of the speed; not of a bias or a gradient, which would be dragged along.
void inflate_acceleration(const Tuning& tuning, State& state, const Sample& sample,
                          double off) noexcept {
  double& a_x = state.covariance(at::accel_x, at::accel_x);
  if (sample.source == Source::accel_x) {
    a_x += off * off;
  } else if (is_wheel(sample.source)) {
    const double pedal = tuning.pedal * gravity;
    a_x += pedal * pedal;
    state.covariance(at::v_x, at::v_x) += off * off;
  }
}

/// What has turned the car otherwise than its tyres should have, since the gyro was last heard: the
/// yaw by half of what it has made of the yaw rate.
void inflate_yaw(State& state, const Sample& sample, double off) noexcept {
  const double since_s =
      std::min(seconds_between(state.readings[index_of(sample.source)].time_ns, sample.time_ns),
               longest_gap_s);
  Vector error = Vector::Zero();
  error[at::yaw_rate] = off;
  error[at::yaw] = 0.5 * since_s * off;
  state.covariance += error * error.transpose();
}

/// Whether a gyro reads on as it has for a while: then the car turns like that, whatever its tyres
/// should make of it. One that slides or spins is followed.
bool continues_steadily(const State& state, const Sample& sample) noexcept {
  return sample.source == Source::yaw_rate && !state.standstill.standing &&
         consistent_samples(state, sample) > 1;
}

/// The heading is the gyro's integral, whatever the tyres' model made of the time between two of
/// its samples: it would detach_from_pose between both, and a model that errs for long would turn
/// the car. This is the trapezium of the two, less what is known of bias and scale. A reading that
/// outliers from those before and after it by more than any car turns in is none: it is replaced by
/// the middle one of the three, for the trapezium before it too. `yaw` and `by` are ψ and its row
/// of B before the newer one was fused.
void integrate_gyro(const CarModel& model, State& state, const Reading& before,
                    const Sample& sample, double yaw, const SlowVector& by) noexcept {
  const SlowVector& s = state.slow.mean;
  const double tau = seconds_between(before.time_ns, sample.time_ns) / (1.0 + s[slow::gyro_scale]);
  const double z = sample.value[0];
  const auto [least, most] = std::minmax(z, before.previous);
  const double outlier = before.value - std::clamp(before.value, least, most);
  const double possible =
      model.tuning.turn_in * gravity / model.car.wheelbase() * before.interval_s;
  const double wrong = std::abs(outlier) > possible && before.interval_s > 0.0 ? outlier : 0.0;
  const double turn = tau * (0.5 * (before.value - wrong + z) - s[slow::gyro_bias]) -
                      0.5 * before.interval_s * wrong;
  state.mean[at::yaw] = yaw - state.turned + turn;
  auto B = state.slow.sensitivity.row(at::yaw);
  B = (by - state.turned_by).transpose();
  B[slow::gyro_bias] -= tau;
  B[slow::gyro_scale] -= turn / (1.0 + s[slow::gyro_scale]);
}

}  // namespace

double rejected_s(State& state, const Sample& sample) noexcept {
  std::int64_t& since_ns = state.rejected_since_ns[index_of(sample.source)];
  since_ns = since_ns == 0 ? sample.time_ns : since_ns;
  return seconds_between(since_ns, sample.time_ns);
}

std::int64_t last_fused_ns(const State& state, Source source) noexcept {
  if (!is_wheel(source)) {
    return state.fused_ns[index_of(source)];
  }
  return last_wheel_ns(state);
}

Judgement judge(const CarModel& model, State& state, const Sample& sample,
                const Prediction& prediction, const Updates& updates) noexcept {
  Innovation nu = innovation(state, prediction, sample.value[0]);
  Judgement judgement{.source = sample.source, .verdict = Verdict::fused, .degrees = 1};
  judgement.innovation[0] = nu.value;
  judgement.variance[0] = nu.variance;
  judgement.squared_ratio = nu.squared_ratio();
  const double possible = possible_change(model, state, sample);
  judgement.test_ratio =
      nu.value * nu.value / (nu.variance + possible * possible) / model.tuning.signal_gate;

  adapt_noise_scales(model.tuning, state, sample, prediction, nu);
  std::int64_t& rejected_ns = state.rejected_since_ns[index_of(sample.source)];
  const bool first = rejected_ns == 0;
  if (!(judgement.test_ratio <= 1.0) && !continues_steadily(state, sample)) {
    judgement.verdict = Verdict::gated;
    const RejectionTimeout timeout = rejection_timeout(sample.source);
    const double before =
        state.readings[index_of(sample.source)].value - sample.value[0] + nu.value;
    if (sample.source == Source::accel_y && before * nu.value <= 0.0) {
      rejected_ns = sample.time_ns;  // vibration is off to both sides
    }
    if (rejected_s(state, sample) < timeout.seconds || !state.integrity.agrees(sample.source)) {
      if (state.standstill.standing && sample.source == Source::accel_x) {
        judgement.degrees = 0;  // felt before the wheels turn: it tests that the car stands
      }
      return judgement;
    }
    judgement.verdict = Verdict::forced;
    // Of a car that stands nothing moves: there, it is the gyro's bias that has changed.
    const double off = nu.value * nu.value;
    if (sample.source == Source::yaw_rate && state.standstill.standing) {
      state.slow.covariance(slow::gyro_bias, slow::gyro_bias) += off;
    } else {
      state.covariance(timeout.inflated, timeout.inflated) += off;
    }
    nu = innovation(state, prediction, sample.value[0]);
  } else if (nu.squared_ratio() > model.tuning.signal_gate && sample.source == Source::yaw_rate) {
    inflate_yaw(state, sample, nu.value);
    state.turn_noise_scale = std::max(state.turn_noise_scale, 0.2);
    nu = innovation(state, prediction, sample.value[0]);
  } else if (nu.squared_ratio() > model.tuning.signal_gate) {
    if (first) {
      rejected_ns = sample.time_ns;
      judgement.verdict = Verdict::gated;  // one telegram alone brakes no car
      return judgement;
    }
    inflate_acceleration(model.tuning, state, sample, nu.value);
    nu = innovation(state, prediction, sample.value[0]);
  }
  rejected_ns = 0;
  state.fused_ns[index_of(sample.source)] = sample.time_ns;
  Vector gain = optimal_gain(nu);
  // The way is what was driven at the speeds that were believed: a speed that is put right moves no
  // position.
  gain[at::x] = gain[at::y] = 0.0;
  if (sample.source == Source::yaw_rate || sample.source == Source::accel_y) {
    // Nor does a turn say how fast a car goes whose wheels do: at walking pace a biased gyro would
    // be explained by a speed that no wheel has.
    gain[at::v_x] = gain[at::accel_x] = gain[at::accel_bias_x] = 0.0;
  }
  if (!updates.heading) {
    // Forces and wheels rest on models that are no better than what they would correct.
    gain[at::yaw] = gain[at::yaw_rate] = gain[at::front_angle] = 0.0;
  }
  const double yaw = state.mean[at::yaw];
  const SlowVector yaw_by = state.slow.sensitivity.row(at::yaw);
  correct(state, nu, gain);
  if (sample.source == Source::yaw_rate) {
    const Reading& before = state.readings[index_of(sample.source)];
    if (updates.heading && !state.standstill.wheels_still && before.consistent > 0 &&
        before.time_ns == state.turned_since_ns &&
        seconds_between(before.time_ns, sample.time_ns) <= longest_gap_s) {
      integrate_gyro(model, state, before, sample, yaw, yaw_by);
    }
    state.turned = 0.0;
    state.turned_by.setZero();
    state.turned_since_ns = sample.time_ns;
  }
  correct_slow_errors(state, nu, updates.slow);
  return judgement;
}

}  // namespace odomd::estimator::full
