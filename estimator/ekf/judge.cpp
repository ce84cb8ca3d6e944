// docs/model.md, "Gates and rejection timeouts".
#include "estimator/ekf/judge.hpp"

#include <algorithm>
#include <cmath>

#include "estimator/common/time.hpp"
#include "estimator/ekf/plausibility.hpp"

namespace odomd::estimator::full {
namespace {

// After a gyro gap this long, wheels and steering determine ψ̇.
constexpr double gyro_lifetime_s = 0.35;

/// Time since `since_ns`, limited to `longest_gap_s` [s].
double gap_s(std::int64_t since_ns, const Sample& sample) noexcept {
  return std::min(seconds_between(since_ns, sample.time_ns), longest_gap_s);
}

/// Largest plausible deviation beyond S. Gyro: the tyres' fastest turn-in; accelerometer: a pedal's
/// acceleration step; wheel without an accelerometer: that step times time.
double possible_change(const CarModel& model, const State& state, const Sample& sample) noexcept {
  const double since_s = gap_s(last_fused_ns(state, sample.source), sample);
  const bool pushed = state.accel_x.seen && gap_s(state.accel_x.time_ns, sample) < longest_gap_s;
  return state.standstill.standing            ? 0.0
         : sample.source == Source::yaw_rate  ? model.turn_in() * since_s
         : sample.source == Source::accel_x   ? model.tuning.pedal * gravity
         : is_wheel(sample.source) && !pushed ? model.tuning.pedal * gravity * since_s
                                              : 0.0;
}

/// Attributes a sudden change `off` to a_x (if from a wheel, also to v_x), not to bias or slope.
void inflate_acceleration(const Tuning& tuning, State& state, const Sample& sample,
                          double off) noexcept {
  double& a_x = state.variance(at::accel_x);
  if (sample.source == Source::accel_x) {
    a_x += off * off;
  } else if (is_wheel(sample.source)) {
    const double pedal = tuning.pedal * gravity;
    a_x += pedal * pedal;
    state.variance(at::v_x) += off * off;
  }
}

/// Adds to the covariance an unpredicted change `off` of the yaw rate since the last gyro sample,
/// and its effect on the yaw: half of `off` times that interval.
void inflate_yaw(State& state, const Sample& sample, double off) noexcept {
  const double since_s = gap_s(state.reading(sample.source).time_ns, sample);
  Vector error = Vector::Zero();
  error[at::yaw_rate] = off;
  error[at::yaw] = 0.5 * since_s * off;
  state.covariance += error * error.transpose();
}

/// Noise with heavy tails (Student's t): for q = ν²/S > 1 the noise of the sample grows until S is
/// (k + q) / (k + 1) times as large.
void weigh(Innovation& nu) noexcept {
  const double more =
      std::max(nu.squared_ratio() - 1.0, 0.0) / (student_degrees + 1.0) * nu.variance;
  nu.variance += more;
  nu.variance_of_noise += more;
}

/// Whether the gyro's readings are consistent. If so, an innovation above the gate means that the
/// car slides or spins, not a gyro fault.
bool continues_steadily(const State& state, const Sample& sample) noexcept {
  return sample.source == Source::yaw_rate && !state.standstill.standing &&
         !ends_pause(state, sample) && consistent_samples(state, sample) > 1;
}

/// Replaces the change of yaw since the last gyro sample, or since a later camera pose, with the
/// trapezium of the two readings, corrected for bias, scale and latency. The update alone would be
/// a compromise between tyre model and gyro, and a model error would turn the pose. A reading that
/// differs from both neighbours by more than a car can turn is an outlier: the median of the three
/// replaces it, also in the previous trapezium. `yaw`, `by`: ψ and its row of B before the update.
void integrate_gyro(const CarModel& model, State& state, const Reading& before,
                    const Sample& sample, double yaw, const SlowVector& by) noexcept {
  const SlowVector& s = state.slow.mean;
  const double per_scale = 1.0 / (1.0 + s[slow::gyro_scale]);
  const double z = sample.value[0];
  const auto [least, most] = std::minmax(z, before.previous);
  const double outlier = before.value - std::clamp(before.value, least, most);
  const double interval_s = seconds_between(before.time_ns, sample.time_ns);
  const double cycle_s = state.integrity.history(sample.source).cycle_s;
  const double possible =
      model.turn_in() * std::min(before.interval_s, std::max(interval_s, cycle_s));
  const double wrong = std::abs(outlier) > possible && before.interval_s > 0.0 ? outlier : 0.0;
  const double since_s = seconds_between(state.turned_since_ns, sample.time_ns);
  const double change = (z - before.value + wrong) * since_s / interval_s;
  const bool whole = state.turned_since_ns == before.time_ns;
  const double tau = since_s * per_scale;
  const double turn = tau * (z - 0.5 * change - s[slow::gyro_bias]) +
                      per_scale * ((s[slow::gyro_latency] - sample.advanced_s) * change -
                                   (whole ? 0.5 * before.interval_s * wrong : 0.0));
  state.mean[at::yaw] = yaw - state.turned + turn;
  auto B = state.slow.sensitivity.row(at::yaw);
  B = (by - state.turned_by).transpose();
  B[slow::gyro_bias] -= tau;
  B[slow::gyro_scale] -= turn * per_scale;
  B[slow::gyro_latency] += change * per_scale;
}

}  // namespace

double rejected_s(State& state, const Sample& sample) noexcept {
  std::int64_t& since_ns = state.reading(sample.source).rejected_since_ns;
  since_ns = since_ns == 0 ? sample.time_ns : since_ns;
  return seconds_between(since_ns, sample.time_ns);
}

std::int64_t last_fused_ns(const State& state, Source source) noexcept {
  return is_wheel(source) ? last_wheel_ns(state) : state.reading(source).fused_ns;
}

bool gyro_alive(const State& state) noexcept {
  if (!state.integrity.trusted(Source::yaw_rate)) {
    return false;
  }
  const std::int64_t gyro_ns = state.reading(Source::yaw_rate).fused_ns;
  return gyro_ns != 0 && seconds_between(gyro_ns, state.time_ns) <= gyro_lifetime_s;
}

Judgement judge(const CarModel& model, State& state, const Sample& sample,
                const Prediction& prediction, const Updates& updates) noexcept {
  Innovation nu = innovation(state, prediction, sample.value[0]);
  const Rules rules = rules_of(sample.source);
  const bool gyro = sample.source == Source::yaw_rate;
  Judgement judgement{.source = sample.source, .verdict = Verdict::fused, .degrees = 1};
  if (is_wheel(sample.source) && state.integrity.slid()) {
    judgement.degrees = 0;  // not a test of the filter
  }
  judgement.innovation[0] = nu.value;
  const double variance = nu.variance - prediction.slip;
  judgement.variance[0] = variance;
  judgement.squared_ratio = nu.value * nu.value / variance;
  const double possible = possible_change(model, state, sample);
  const double gate = model.tuning.*rules.gate;
  const auto test_ratio = [&](double of) {
    return nu.value * nu.value / (of + possible * possible) / gate;
  };
  judgement.test_ratio = test_ratio(variance);  // without slip, so that slip does not lower it

  adapt_noise_scales(model.tuning, state, sample, prediction, nu);
  std::int64_t& rejected_ns = state.reading(sample.source).rejected_since_ns;
  const bool first = rejected_ns == 0;
  const bool bias = gyro && state.standstill.standing;
  if (!bias && !(test_ratio(nu.variance) <= 1.0) && !continues_steadily(state, sample)) {
    judgement.verdict = Verdict::gated;
    const double before = state.reading(sample.source).value - sample.value[0] + nu.value;
    if (sample.source == Source::accel_y && before * nu.value <= 0.0) {
      rejected_ns = sample.time_ns;  // a vibration deviates in both directions
    }
    // While another wheel is fused, this wheel is wrong, not the filter.
    const double alone_s = seconds_between(last_fused_ns(state, sample.source), sample.time_ns);
    if (std::min(rejected_s(state, sample), alone_s) < rules.timeout_s ||
        !state.integrity.agrees(sample.source)) {
      if (state.standstill.standing && sample.source == Source::accel_x) {
        judgement.degrees = 0;  // the car may be setting off: not a test of the filter
      }
      return judgement;
    }
    judgement.verdict = Verdict::forced;
    state.variance(rules.inflated) += nu.value * nu.value;
    nu = innovation(state, prediction, sample.value[0]);
  } else if (!bias && nu.squared_ratio() > gate && gyro && !(first && ends_pause(state, sample))) {
    inflate_yaw(state, sample, nu.value);
    state.turn_noise_scale = std::max(state.turn_noise_scale, 0.2);
    nu = innovation(state, prediction, sample.value[0]);
  } else if (!bias && nu.squared_ratio() > gate) {
    if (first) {
      rejected_ns = sample.time_ns;
      judgement.verdict = Verdict::gated;  // one corrupt frame must not brake or turn the car
      return judgement;
    }
    inflate_acceleration(model.tuning, state, sample, nu.value);
    nu = innovation(state, prediction, sample.value[0]);
  }
  state.note_fused(sample.source, sample.time_ns);
  if (is_wheel(sample.source)) {
    weigh(nu);
  }
  Vector gain = optimal_gain(nu);
  // A speed correction must not move the position: that would be a correction of the past.
  gain[at::x] = gain[at::y] = 0.0;
  if (rules.turn) {
    // A turn must not correct the speed: at walking pace the speed would absorb a gyro bias.
    gain[at::v_x] = gain[at::accel_x] = gain[at::accel_bias_x] = 0.0;
  }
  if (!updates.heading) {
    // Force and wheel models are no more certain than the heading that they would correct.
    gain[at::yaw] = gain[at::yaw_rate] = gain[at::front_angle] = 0.0;
  }
  const double yaw = state.mean[at::yaw];
  const SlowVector yaw_by = state.slow.sensitivity.row(at::yaw);
  correct(state, nu, gain);
  if (gyro) {
    const Reading& before = state.reading(sample.source);
    if (updates.heading && !state.standstill.wheels_still && before.consistent > 0 &&
        before.time_ns <= state.turned_since_ns &&
        seconds_between(before.time_ns, sample.time_ns) <= longest_gap_s) {
      integrate_gyro(model, state, before, sample, yaw, yaw_by);
    }
    state.turned = 0.0;
    state.turned_by.setZero();
    state.turned_since_ns = sample.time_ns;
  }
  // Noise mistaken for a force would make the learnt gradient too small.
  SlowVector learns = updates.slow;
  for (const slow::Index gradient : {slow::roll_gradient, slow::pitch_gradient}) {
    const double uncertain = nu.variance_of_noise - prediction.variance;
    if (squared(prediction.by_slow[gradient]) <= squared(most_sigmas) * uncertain) {
      learns[gradient] = 0.0;
    }
  }
  correct_slow_errors(state, nu, learns);
  return judgement;
}

}  // namespace odomd::estimator::full
