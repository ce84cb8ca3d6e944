// docs/model.md, "Process".
#include "estimator/ekf/take.hpp"

#include <algorithm>
#include <cmath>

#include "estimator/common/symmetric3.hpp"
#include "estimator/common/time.hpp"
#include "estimator/ekf/judge.hpp"
#include "estimator/ekf/measurement_models.hpp"
#include "estimator/ekf/plausibility.hpp"
#include "estimator/ekf/standstill.hpp"
#include "estimator/ekf/update.hpp"

namespace odomd::estimator::full {
namespace {

// An older steering sample is ignored.
constexpr double steering_lifetime_s = 0.5;

// Fastest turn of the front wheels [rad/s].
constexpr double fastest_steering = 20.0;

void hold(HeldInput& held, const Sample& sample) noexcept {
  held = {true, sample.time_ns, sample.value[0]};
}

bool alive(const HeldInput& held, std::int64_t now_ns, double lifetime_s) noexcept {
  return held.seen && seconds_between(held.time_ns, now_ns) <= lifetime_s;
}

/// Verdicts without a test: the sample is an input, or there is nothing to test it against.
Judgement held(Source source) noexcept {
  return {.source = source};
}
Judgement gated(Source source) noexcept {
  return {.source = source, .verdict = Verdict::gated};
}

/// A few turning or locked wheels neither begin nor end a still period.
Judgement note(const Context& context, State& state, const Sample& sample,
               const Judgement& judgement) noexcept {
  const bool turning = is_turning(sample.value[0], sample.sigma[0]);
  const WheelCount wheels = count_wheels(context.model.car.driven, state, sample);
  const bool most_still = wheels.still > wheels.turning;
  if (most_still && !turning && is_taken(judgement.verdict)) {
    note_wheels(state, sample, true);
  } else if (!most_still ||
             (!turning && seconds_between(last_wheel_ns(state), sample.time_ns) > next_sample_s)) {
    // The car slides only if all its wheels are gated: if the wheels of one side were enough, a
    // biased gyro would turn the car about the other side.
    note_wheels(state, sample, false);
  }
  return judgement;
}

Judgement take_wheel(const Context& context, State& state, const Sample& sample) noexcept {
  const double speed = sample.value[0];
  const double sigma = sample.sigma[0];
  const bool turning = is_turning(speed, sigma);
  if (!state.moving) {
    if (consistent_samples(state, sample) == 0) {
      return held(sample.source);
    }
    begin_motion(state, sample);
  }
  correct_start(state, sample);
  if (turning) {
    state.standstill.blind = 0.0;
  }
  if (state.standstill.standing) {
    if (!turning) {
      state.note_fused(sample.source, sample.time_ns);
      return held(sample.source);
    }
    const WheelCount wheels = count_wheels(context.model.car.driven, state, sample);
    if (!sets_off(state, sample, wheels)) {
      return gated(sample.source);
    }
    set_off(context.model, state, wheels.slowest);
  }
  const bool gyro = gyro_alive(state);
  const auto predict = [&] {
    return predict_wheel_speed(context.model, input_of(state), state, sample.source, sigma, gyro,
                               sample.advanced_s);
  };
  Prediction z = predict();
  if (!turning) {
    // A reading of 0 means any speed within the dead band: it narrows the estimate to the band.
    const double known = state.variance(at::v_x);
    const double dead_band = state.standstill.dead_band[index_of(sample.source)];
    const double band = third * squared(dead_band);
    if (known <= band && std::abs(state.mean[at::v_x]) <= dead_band) {
      state.note_fused(sample.source, sample.time_ns);
      return note(context, state, sample, held(sample.source));
    }
    z.by_slow[slow::wheel_scale] = z.by_slow[slow::wheel_difference] = 0.0;
    z.variance += known > band ? band * known / (known - band) : band;
  }
  double& noise_scale = state.reading(sample.source).noise_scale;
  const double before = noise_scale;
  const bool surprising = noise_scale < 1.0 && innovation(state, z, speed).squared_ratio() >
                                                   context.model.tuning.signal_gate;
  if (surprising) {
    noise_scale = 1.0;  // the wheel's errors may have grown
    z = predict();
  }
  const Judgement judgement = judge(context.model, state, sample, z, {.heading = !gyro});
  if (surprising && !is_taken(judgement.verdict)) {
    noise_scale = before;
  }
  return turning && !state.standstill.wheels_still ? judgement
                                                   : note(context, state, sample, judgement);
}

Judgement take_accel_x(const Context& context, State& state, const Sample& sample) noexcept {
  if (state.accel_x.seen && consistent_samples(state, sample) == 0) {
    return gated(sample.source);
  }
  hold(state.accel_x, sample);
  return judge(context.model, state, sample, predict_accel_x(context.model, state, sample.sigma[0]),
               {.slow = only(slow::pitch_gradient)});
}

/// A tyre has more grip than it has shown: 1/μ ≤ `grip_used` / |a_y|.
void note_shown_grip(const CarModel& model, State& state, double accel, double elapsed_s) noexcept {
  const double time_s = std::clamp(elapsed_s, 0.0, longest_gap_s);
  state.side_accel += (accel - state.side_accel) * time_s / (model.tuning.grip_shown_s + time_s);
  state.largest_accel = std::max(state.largest_accel, std::abs(state.side_accel));
  const double usual = usual_softness(0.0);
  double& softness = state.slow.mean[slow::softness];
  const double allowed = std::clamp(
      softness, -usual, std::max(model.tuning.grip_used / state.largest_accel - usual, -usual));
  state.mean += (allowed - softness) * state.slow.sensitivity.col(slow::softness);
  softness = allowed;
}

/// Learns the grip unless it is configured. Banked roads look like grip; the camera corrects that.
Judgement take_accel_y(const Context& context, State& state, const Sample& sample) noexcept {
  const CarModel& model = context.model;
  const bool teaches = model.car.grip_rear == 0.0;
  const double elapsed_s =
      state.accel_y.seen ? seconds_between(state.accel_y.time_ns, sample.time_ns) : 0.0;
  hold(state.accel_y, sample);
  Updates updates{.heading = !gyro_alive(state), .slow = only(slow::roll_gradient)};
  if (teaches) {
    updates.slow += only(slow::softness);
  }
  const Judgement judgement = judge(
      model, state, sample,
      predict_accel_y(model, input_of(state), state, sample.sigma[0], context.period_s), updates);
  if (teaches && judgement.verdict == Verdict::fused) {
    note_shown_grip(model, state, sample.value[0] - state.mean[at::accel_bias_y], elapsed_s);
  }
  return judgement;
}

/// A jump beyond the fastest turn may be corrupt: the variance grows by the square of the excess.
Judgement take_steering(State& state, const Sample& sample) noexcept {
  if (!state.steering.seen) {
    state.front_wheels = sample.value[0];
  } else {
    const double elapsed_s =
        std::min(seconds_between(state.steering.time_ns, sample.time_ns), longest_gap_s);
    const double jump = std::abs(sample.value[0] - state.steering.value);
    const double excess = std::max(jump - fastest_steering * elapsed_s, 0.0);
    state.variance(at::front_angle) += excess * excess;
  }
  hold(state.steering, sample);
  return held(sample.source);
}

/// The motion is not known yet, so nothing is fused. The yaw rate starts at the gyro's reading.
Judgement hold_before_motion(State& state, const Sample& sample) noexcept {
  if (consistent_samples(state, sample) == 0) {
    return held(sample.source);
  }
  state.reading(sample.source).fused_ns = sample.time_ns;
  if (sample.source == Source::yaw_rate) {
    state.mean[at::yaw_rate] = sample.value[0] - state.slow.mean[slow::gyro_bias];
  } else {
    hold(sample.source == Source::accel_x ? state.accel_x : state.accel_y, sample);
  }
  return held(sample.source);
}

/// After a silence the covariance is too wide to gate: two earlier samples must be consistent.
Judgement take_signal(const Context& context, State& state, const Sample& sample) noexcept {
  const std::int64_t fused_ns = last_fused_ns(state, sample.source);
  if (fused_ns != 0 && seconds_between(fused_ns, sample.time_ns) > silence_s &&
      consistent_samples(state, sample) < 2) {
    return gated(sample.source);
  }
  if (!state.moving && !is_wheel(sample.source)) {
    return hold_before_motion(state, sample);
  }
  switch (sample.source) {
    case Source::yaw_rate:
      return state.standstill.standing ? take_still_gyro(context.model, state, sample)
             : ends_pause(state, sample, longest_gap_s)  // the next reading must confirm it
                 ? held(sample.source)
                 : judge(context.model, state, sample,
                         predict_yaw_rate(state, sample.sigma[0], sample.advanced_s),
                         {.heading = true});
    case Source::accel_x:
      return take_accel_x(context, state, sample);
    case Source::accel_y:
      return take_accel_y(context, state, sample);
    default:
      return take_wheel(context, state, sample);
  }
}

/// The front wheels follow the command, within the rate limit:
/// δ' = δ + (δ_c - δ) (1 - exp(-Δt / T)). Returns the change.
double steer(const SteeringActuator& actuator, double dt, State& state) noexcept {
  const double share = actuator.lag_s > 0.0 ? -std::expm1(-dt / actuator.lag_s) : 1.0;
  double change = share * (state.steering.value - state.front_wheels);
  if (actuator.rate_limit > 0.0) {
    change = std::clamp(change, -actuator.rate_limit * dt, actuator.rate_limit * dt);
  }
  state.front_wheels += change;
  return change;
}

}  // namespace

Input input_of(const State& state) noexcept {
  return {.steering = state.front_wheels,
          .has_steering = alive(state.steering, state.time_ns, steering_lifetime_s) &&
                          state.integrity.trusted(Source::steering)};
}

void advance(const Context& context, State& state, std::int64_t time_ns) noexcept {
  double left = seconds_between(state.time_ns, time_ns);
  if (!(left > 0.0)) {
    return;
  }
  if (!state.moving) {
    state.time_ns = time_ns;
    return;
  }
  if (state.standstill.standing && wheel_silence_s(state, time_ns) > 0.0) {
    doubt_standstill(context.model, state, time_ns);
  }
  if (state.standstill.standing) {
    steer(context.model.car.steering, left, state);
    propagate_standing(context.model, left, state);
    state.time_ns = time_ns;
    return;
  }
  const auto step = [&](double dt) {
    const double change = steer(context.model.car.steering, dt, state);
    Input input = input_of(state);
    input.change = change;
    propagate(context.model, input, dt, state);
  };
  for (; left > 1.5 * context.period_s; left -= context.period_s) {
    step(context.period_s);
  }
  step(left);
  state.time_ns = time_ns;
}

Judgement take(const Context& context, State& state, const Sample& sample) noexcept {
  switch (sample.source) {
    case Source::camera: {
      state.integrity.add({.capture_ns = sample.time_ns,
                           .x = sample.value[0],
                           .y = sample.value[1],
                           .yaw = sample.value[2],
                           .sigma_x = sample.sigma[0],
                           .sigma_y = sample.sigma[1],
                           .sigma_yaw = sample.sigma[2]});
      const PosePair before = state.last_camera_pose;
      note_camera_pose(state, sample);
      if (!state.integrity.trusted(Source::camera)) {
        // A distrusted camera needs more evidence before it may reset the filter.
        state.camera_evidence = -2.0 * context.model.tuning.outlier_odds;
        return gated(sample.source);
      }
      const Judgement judgement = take_camera(context.model, context.camera, state, before, sample);
      update_standstill(context.model, state, sample);
      return judgement;
    }
    case Source::steering: {
      const bool lags =
          context.model.car.steering.lag_s > 0.0 || context.model.car.steering.rate_limit > 0.0;
      state.integrity.add(sample.source, sample.time_ns,
                          lags && state.steering.seen ? state.front_wheels : sample.value[0],
                          sample.sigma[0]);
      return take_steering(state, sample);
    }
    case Source::direction: {
      const Verdict verdict = take_direction(context.model, state, sample);
      if (is_taken(verdict)) {
        state.integrity.add(sample.source, sample.time_ns, sample.value[0], sample.sigma[0]);
      }
      return {.source = sample.source, .verdict = verdict};
    }
    default:
      break;
  }
  if (is_wheel(sample.source) && lost_direction(state)) {
    state.integrity.forget(Source::direction);
    state.direction.value = 0.0;
  }
  Sample reading = sample;
  if (!is_wheel(sample.source)) {
    measure_noise(context.model.tuning, state, reading);
  } else if (state.direction.seen && state.direction.value < 0.0) {
    // Unsigned speeds take the sign of the direction.
    reading.value[0] = -std::abs(sample.value[0]);
  }
  // A late sensor is alive while its samples arrive, whenever they were taken.
  state.integrity.add(reading.source, reading.time_ns, reading.value[0], reading.sigma[0],
                      ns_after(reading.time_ns, std::llround(reading.advanced_s * ns_per_second)));
  if (is_wheel(sample.source) && state.integrity.backwards()) {
    reading.value[0] = -std::abs(sample.value[0]);
  }
  update_standstill(context.model, state, reading);
  const Source source = sample.source;
  Judgement judgement =
      state.integrity.trusted(source) ? take_signal(context, state, reading) : gated(source);
  if (is_wheel(source)) {
    learn_dead_band(state, reading);
    if (judgement.verdict == Verdict::fused && judgement.test_ratio > 1.0) {
      judgement.verdict = Verdict::gated;  // a slipping wheel has little weight
    }
  }
  note_reading(state, reading);
  return judgement;
}

}  // namespace odomd::estimator::full
