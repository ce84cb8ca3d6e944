#include "estimator/full_filter.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "estimator/physical_limits.hpp"
#include "estimator/pose.hpp"
#include "estimator/symmetric3.hpp"
#include "estimator/time.hpp"

namespace odomd::estimator {
namespace {

using full::Sample;
using full::State;
namespace at = full::at;

// A gap is made up for step by step up to here; beyond, the covariance grows.
constexpr std::int64_t most_ticks_made_up = 200;

// Farther off [m], a double resolves a step no longer.
constexpr double largest_coordinate = 1e8;
constexpr double largest_sigma = 1e3;
constexpr double smallest_sigma = 1e-6;

// No car and no sensor gets here; numbers that do would overflow somewhere.
constexpr double largest_position = 1e9;
constexpr double largest_state = 1e4;
constexpr double fastest = 300.0;       // [m/s]
constexpr double fastest_turn = 100.0;  // [rad/s]

/// What nothing is known beyond: half a turn, a kilometre, 100 m/s.
constexpr std::array<double, at::size> largest_deviation{1e3,  1e3, 3.2, 1e2, 1e2, 35.0, 1e2, 1e2,
                                                         10.0, 0.5, 0.9, 1.0, 0.5, 10.0, 0.5};

/// The states that a Calibration tells of, in its order, and what it adds to them.
struct Calibrated {
  at::Index state;
  double neutral;
};
constexpr std::array<Calibrated, calibration_count> calibrated{{{at::gyro_bias, 0.0},
                                                                {at::gyro_scale, 1.0},
                                                                {at::accel_bias_x, 0.0},
                                                                {at::accel_bias_y, 0.0},
                                                                {at::wheel_scale, 1.0},
                                                                {at::steering_offset, 0.0},
                                                                {at::stiffness_scale, 1.0}}};

/// How far each state may be off before anything was measured.
full::Vector prior(const FilterSettings& settings) noexcept {
  const std::array<double, at::size> sigma{
      settings.initial_sigma_position,
      settings.initial_sigma_position,
      settings.initial_sigma_yaw,  //
      1.0,
      0.5,
      1.0,   // v_x, v_y [m/s], yaw_rate [rad/s]
      1.5,   // front_force [m/s²]
      1.5,   // yaw_moment [rad/s²]
      0.3,   // accel_bias_x [m/s²]
      0.02,  // steering_offset [rad]
      0.15,  // stiffness_scale
      0.03,  // gyro_bias [rad/s]
      0.02,  // gyro_scale
      0.3,   // accel_bias_y [m/s²]
      0.03,  // wheel_scale
  };
  return full::Vector(sigma.data());
}

// Rounding takes the last digits of a strongly correlated P; this keeps it positive definite, and
// makes it 1.7 % larger in a day.
constexpr double inflation = 1.0 + 1e-9;

/// D P D, D = diag of at most 1, that brings the variances down to their limits.
void limit(full::Matrix& P) noexcept {
  P.diagonal() *= inflation;
  for (Eigen::Index i = 0; i < at::size; ++i) {
    const double largest = largest_deviation[static_cast<std::size_t>(i)];
    if (P(i, i) > largest * largest) {
      const double factor = largest / std::sqrt(P(i, i));
      P.row(i) *= factor;
      P.col(i) *= factor;
    }
  }
}

bool sound(const State& state) noexcept {
  return state.mean.allFinite() && state.mean.head<2>().cwiseAbs().maxCoeff() < largest_position &&
         state.mean.tail<at::size - 3>().cwiseAbs().maxCoeff() < largest_state &&
         state.mean.segment<2>(at::v_x).cwiseAbs().maxCoeff() < fastest &&
         std::abs(state.mean[at::yaw_rate]) < fastest_turn && state.covariance.allFinite() &&
         Eigen::LLT<full::Matrix>(state.covariance).info() == Eigen::Success;
}

BodyVelocity velocity_of(const State& state) noexcept {
  return {state.mean[at::v_x], state.mean[at::v_y], state.mean[at::yaw_rate]};
}

}  // namespace

FullFilter::FullFilter(const FilterSettings& settings) noexcept
    : initial_sigma_(prior(settings)),
      period_ns_(std::llround(settings.period_s * ns_per_second)),
      window_ns_(std::llround(settings.window_s * ns_per_second)),
      camera_latency_ns_(std::llround(settings.camera_max_latency_s * ns_per_second)),
      modes_(settings.camera_timeout_s) {
  context_.model = {settings.vehicle, settings.imu_position, settings.full};
  context_.wheels = settings.wheels;
  context_.camera = {settings.camera_gate, settings.initialise_from_camera};
  context_.period_s = settings.period_s;
  for (std::size_t i = 0; i < source_count; ++i) {
    sigma_[i] = settings.sigma[i] > 0.0 ? settings.sigma[i] : default_sigma[i];
  }
  const std::int64_t window_ticks = window_ns_ / period_ns_ + 1;
  stride_ = window_ticks / static_cast<std::int64_t>(kept_states - 3) + 1;
  now_.covariance.diagonal() = initial_sigma_.array().square();
}

void FullFilter::set_initial_pose(const Pose2& pose) noexcept {
  if (!is_finite(pose)) {
    return;
  }
  const Pose2 before = now_.pose();
  now_.mean.segment<3>(at::x) << pose.x, pose.y, pose.yaw;
  now_.covariance.topRows<3>().setZero();
  now_.covariance.leftCols<3>().setZero();
  now_.covariance.diagonal().head<3>() = initial_sigma_.head<3>().array().square();
  const bool located_before = now_.located;
  now_.located = true;
  // Nothing that came before may be replayed across it.
  if (last_tick_ns_) {
    kept_count_ = 0;
    keep();
  }
  if (!located_before) {
    odom_ = pose;
    reset_count_ = 1;
    return;
  }
  ++reset_count_;
  last_jump_ = {pose.x - before.x, pose.y - before.y, pose.yaw - before.yaw};
}

std::optional<Verdict> FullFilter::add(const Measurement& sample) noexcept {
  const auto index = static_cast<std::size_t>(sample.source);
  if (index >= source_count || sample.source == Source::camera) {
    return Verdict::source_off;
  }
  if (!std::isfinite(sample.value) || !std::isfinite(sample.sigma) || sample.sigma < 0.0) {
    return Verdict::non_finite;
  }
  if (std::abs(sample.value) > physical_limit[index]) {
    return Verdict::gated;
  }
  const double sigma = sample.sigma > 0.0 ? sample.sigma : sigma_[index];
  return insert({.time_ns = sample.time_ns,
                 .source = sample.source,
                 .value = {sample.value},
                 .sigma = {std::clamp(sigma, smallest_sigma, physical_limit[index])}},
                sample.arrival_ns);
}

std::optional<Verdict> FullFilter::add(const CameraPose& camera) noexcept {
  const auto is_sigma = [](double sigma) { return std::isfinite(sigma) && sigma > 0.0; };
  if (!std::isfinite(camera.x) || !std::isfinite(camera.y) || !std::isfinite(camera.yaw) ||
      !is_sigma(camera.sigma_x) || !is_sigma(camera.sigma_y) || !is_sigma(camera.sigma_yaw)) {
    return Verdict::non_finite;
  }
  if (std::abs(camera.x) > largest_coordinate || std::abs(camera.y) > largest_coordinate) {
    return Verdict::gated;
  }
  if (camera.arrival_ns != 0 &&
      ns_between(camera.capture_ns, camera.arrival_ns) > camera_latency_ns_) {
    return Verdict::too_old;
  }
  const auto bounded = [](double sigma) {
    return std::clamp(sigma, smallest_sigma, largest_sigma);
  };
  return insert(
      {.time_ns = camera.capture_ns,
       .source = Source::camera,
       .value = {camera.x, camera.y, wrap_angle(camera.yaw)},
       .sigma = {bounded(camera.sigma_x), bounded(camera.sigma_y), bounded(camera.sigma_yaw)}},
      camera.arrival_ns);
}

std::optional<Verdict> FullFilter::insert(const Sample& sample, std::int64_t arrival_ns) noexcept {
  const std::int64_t next_tick_ns = last_tick_ns_ ? ns_after(*last_tick_ns_, period_ns_)
                                                  : std::numeric_limits<std::int64_t>::max();
  if (sample.time_ns > ns_after(arrival_ns != 0 ? arrival_ns : next_tick_ns, period_ns_)) {
    return Verdict::future;
  }
  if (last_tick_ns_ &&
      sample.time_ns <= std::max({ns_after(*last_tick_ns_, -window_ns_), window_.lost_until_ns(),
                                  kept(kept_count_ - 1).time_ns})) {
    return Verdict::too_old;
  }
  const full::Insertion insertion = window_.insert(sample);
  if (insertion == full::Insertion::given_up) {
    return Verdict::too_old;
  }
  if (insertion != full::Insertion::duplicate) {
    oldest_news_ns_ = std::min(oldest_news_ns_, sample.time_ns);
  }
  return insertion == full::Insertion::inserted ? std::nullopt : std::optional(Verdict::duplicate);
}

Estimate FullFilter::step(std::int64_t tick_ns) noexcept {
  judgement_count_ = 0;
  const bool first = !last_tick_ns_;
  if (first) {
    begin(tick_ns);
  } else if (ns_between(*last_tick_ns_, tick_ns) < period_ns_ / 2) {
    return last_;
  }
  const bool located_before = now_.located;
  const BodyVelocity before = velocity_of(now_);

  // 1. Back to where the oldest of the new samples belongs, and from there to now.
  go_back_to(oldest_news_ns_);
  oldest_news_ns_ = std::numeric_limits<std::int64_t>::max();
  replay_to(tick_ns);
  if (!sound(now_)) {
    recover(tick_ns);
  }

  // 2. The odometry frame: what was published, integrated.
  const double dt = seconds_between(*last_tick_ns_, tick_ns);
  const BodyVelocity after = velocity_of(now_);
  if (now_.located && !located_before) {
    odom_ = now_.pose();
    reset_count_ = 1;
  } else if (now_.moving && !first) {
    odom_ = moved(odom_,
                  {0.5 * (before.v_x + after.v_x), 0.5 * (before.v_y + after.v_y),
                   0.5 * (before.yaw_rate + after.yaw_rate)},
                  dt);
  }
  // A jump that a replay takes back is one more jump.
  if (now_.resets != seen_resets_) {
    reset_count_ += 1;
    last_jump_ = now_.last_jump;
    seen_resets_ = now_.resets;
  }

  last_tick_ns_ = tick_ns;
  // 3. What is older than the window and all kept states, and what is from the future, must go.
  const std::int64_t oldest_ns =
      std::min(ns_after(tick_ns, -window_ns_), kept(kept_count_ - 1).time_ns);
  refuse(window_.until(oldest_ns), Verdict::too_old);
  window_.forget_until(oldest_ns);
  const std::int64_t newest_ns = ns_after(tick_ns, period_ns_);
  refuse(window_.after(newest_ns), Verdict::future);
  window_.forget_after(newest_ns);
  last_ = estimate(tick_ns);
  return last_;
}

/// The first tick: the state begins a window before it, so that what has come in already counts;
/// one that a predecessor has left is of the tick before.
void FullFilter::begin(std::int64_t tick_ns) noexcept {
  now_.time_ns = ns_after(tick_ns, now_.moving ? -period_ns_ : -window_ns_ - period_ns_);
  kept_count_ = 0;
  keep();
  last_tick_ns_ = now_.time_ns;
}

void FullFilter::keep() noexcept {
  newest_kept_ = (newest_kept_ + 1) % kept_states;
  kept_[newest_kept_] = now_;
  kept_count_ = std::min(kept_count_ + 1, kept_states);
}

/// The verdict of those that will never be taken in.
void FullFilter::refuse(std::span<const Sample> samples, Verdict verdict) noexcept {
  for (const Sample& sample : samples) {
    if (!sample.judged && judgement_count_ < judgements_.size()) {
      judgements_[judgement_count_++] = {
          .source = sample.source, .verdict = verdict, .time_ns = sample.time_ns};
    }
  }
}

/// To the newest kept state before `time_ns`, if now_ is not before it.
void FullFilter::go_back_to(std::int64_t time_ns) noexcept {
  if (now_.time_ns < time_ns || kept_count_ == 0) {
    return;
  }
  while (kept_count_ > 1 && kept(0).time_ns >= time_ns) {
    newest_kept_ = (newest_kept_ + kept_states - 1) % kept_states;
    --kept_count_;
  }
  now_ = kept(0);
}

/// Takes the samples after now_ up to `tick_ns`, on the grid of the ticks.
void FullFilter::replay_to(std::int64_t tick_ns) noexcept {
  std::span<Sample> samples = window_.after(now_.time_ns);
  const std::int64_t behind = ns_between(now_.time_ns, tick_ns);
  std::int64_t ticks = behind / period_ns_ + (behind % period_ns_ >= period_ns_ / 2 ? 1 : 0);
  if (ticks > most_ticks_made_up + window_ns_ / period_ns_) {
    // Asleep: nobody knows what the car did before the last second.
    ticks = most_ticks_made_up;
    const std::int64_t awake_ns = ns_after(tick_ns, -ticks * period_ns_);
    const double gap_s = seconds_between(now_.time_ns, awake_ns);
    last_tick_ns_ = now_.time_ns = awake_ns;
    const double half_square = 0.5 * gap_s * gap_s;
    now_.covariance.diagonal().head<3>() +=
        Eigen::Vector3d(2.0 * half_square, 2.0 * half_square, 5.0 * half_square)
            .array()
            .square()
            .matrix();
    limit(now_.covariance);
    kept_count_ = 0;
    keep();
    samples = window_.after(now_.time_ns);
  }
  for (std::int64_t left = ticks; left-- > 0;) {
    const std::int64_t grid_ns = ns_after(tick_ns, -left * period_ns_);
    while (!samples.empty() && samples.front().time_ns <= grid_ns) {
      Sample& sample = samples.front();
      full::advance(context_, now_, sample.time_ns);
      const Judgement judgement = full::take(context_, now_, sample);
      if (!sample.judged && judgement_count_ < judgements_.size()) {
        sample.judged = true;
        judgements_[judgement_count_] = judgement;
        judgements_[judgement_count_++].time_ns = sample.time_ns;
      }
      samples = samples.subspan(1);
    }
    full::advance(context_, now_, grid_ns);
    limit(now_.covariance);
    if ((grid_ns / period_ns_) % stride_ == 0 || kept_count_ == 0) {
      keep();
    }
  }
}

/// A state that is no state: on from the last that was published, as if newly begun.
void FullFilter::recover(std::int64_t tick_ns) noexcept {
  ++recoveries_;
  State fresh;
  fresh.time_ns = tick_ns;
  fresh.located = now_.located;
  fresh.moving = now_.moving;
  fresh.resets = now_.resets;
  if (last_.initialised) {
    fresh.mean.segment<3>(at::x) << last_.map.x, last_.map.y, last_.map.yaw;
    fresh.mean.segment<3>(at::v_x) << last_.v_x, last_.v_y, last_.yaw_rate;
  }
  fresh.covariance.diagonal() = initial_sigma_.array().square();
  now_ = fresh;
  kept_count_ = 0;
  keep();
}

bool FullFilter::resume(const Estimate& predecessor, double gap_s) noexcept {
  const BodyVelocity velocity{predecessor.v_x, predecessor.v_y, predecessor.yaw_rate};
  const Symmetric3& P = predecessor.covariance;
  const bool usable = predecessor.initialised && !predecessor.model_fault && gap_s >= 0.0 &&
                      std::isfinite(gap_s) && is_finite(predecessor.map) &&
                      is_finite(predecessor.odom) && is_finite(velocity) && is_finite(P) &&
                      is_positive_definite(P);
  if (!usable) {
    return false;
  }
  const Pose2 map = moved(predecessor.map, velocity, gap_s);
  odom_ = moved(predecessor.odom, velocity, gap_s);
  now_.mean.segment<3>(at::x) << map.x, map.y, map.yaw;
  now_.mean.segment<3>(at::v_x) << velocity.v_x, velocity.v_y, velocity.yaw_rate;
  const double half_square = 0.5 * gap_s * gap_s;
  const Symmetric3 grown = displaced(P, map.x - predecessor.map.x, map.y - predecessor.map.y);
  auto& covariance = now_.covariance;
  covariance.topLeftCorner<3, 3>() << grown[0], grown[1], grown[2],  //
      grown[1], grown[3], grown[4],                                  //
      grown[2], grown[4], grown[5];
  covariance(at::x, at::x) += half_square * half_square * 4.0;
  covariance(at::y, at::y) += half_square * half_square * 4.0;
  covariance(at::yaw, at::yaw) += half_square * half_square * 25.0;
  const Calibration& known = predecessor.calibration;
  for (std::size_t i = 0; i < calibration_count; ++i) {
    const auto [state, neutral] = calibrated[i];
    const double value = known.value[i] - neutral;
    const double sigma = known.sigma[i];
    if (std::isfinite(value) && sigma > 0.0 && sigma < initial_sigma_[state]) {
      now_.mean[state] = value;
      covariance(state, state) = sigma * sigma;
    }
  }
  now_.located = true;
  now_.moving = true;
  reset_count_ = predecessor.reset_count + 1;
  last_jump_ = {};
  return true;
}

Estimate FullFilter::estimate(std::int64_t tick_ns) noexcept {
  const full::Vector& x = now_.mean;
  const full::Matrix& P = now_.covariance;
  Estimate e;
  e.time_ns = tick_ns;
  e.initialised = now_.located && now_.moving;
  e.map = now_.pose();
  e.odom = odom_;
  e.v_x = x[at::v_x];
  e.v_y = x[at::v_y];
  e.yaw_rate = x[at::yaw_rate];
  e.covariance = {P(0, 0), P(0, 1), P(0, 2), P(1, 1), P(1, 2), P(2, 2)};
  e.velocity_covariance = {P(3, 3), P(3, 4), P(3, 5), P(4, 4), P(4, 5), P(5, 5)};
  for (std::size_t i = 0; i < 9; ++i) {
    e.cross_covariance[i] =
        P(static_cast<Eigen::Index>(i / 3), 3 + static_cast<Eigen::Index>(i % 3));
  }
  e.accel_x = now_.accel_x.value;
  e.accel_y = now_.accel_y.value;
  e.steering = now_.steering.value;
  e.reset_count = reset_count_;
  e.last_jump = last_jump_;
  e.camera_ns = now_.fused_ns[static_cast<std::size_t>(Source::camera)];
  e.camera_test_ratio = now_.camera_test_ratio;
  e.recoveries = recoveries_;

  for (std::size_t i = 0; i < calibration_count; ++i) {
    const auto [state, neutral] = calibrated[i];
    e.calibration.value[i] = x[state] + neutral;
    e.calibration.sigma[i] = std::sqrt(P(state, state));
    if (e.calibration.sigma[i] < 0.4 * initial_sigma_[state]) {
      e.calibration.valid |= std::uint64_t{1} << i;
    }
  }

  e.mode = modes_.update({.time_ns = tick_ns,
                          .initialised = e.initialised,
                          .fault = false,
                          .wheel_speed = now_.rest.standing ? 0.0 : std::max(std::abs(e.v_x), 0.1),
                          .yaw_rate = e.yaw_rate,
                          .camera_ns = e.camera_ns});
  if (!now_.rest.standing && e.initialised) {
    // What a client integrates for up to 100 ms: the mean rate of the next 60 ms, in which the
    // tyres settle. The rate of this instant would run away from the filter's own propagation.
    const full::Input input = full::input_of(now_);
    Eigen::Matrix<double, 8, 1> ahead = x.segment<8>(at::v_x);
    constexpr int steps = 12;
    constexpr double dt = 0.005;
    for (int i = 0; i < steps; ++i) {
      ahead.head<3>() = full::next_velocity<double>(context_.model, input, ahead, dt);
    }
    e.v_x_dot = (ahead[0] - e.v_x) / (steps * dt);
    e.v_y_dot = (ahead[1] - e.v_y) / (steps * dt);
    e.yaw_accel = (ahead[2] - e.yaw_rate) / (steps * dt);
  }
  return e;
}

}  // namespace odomd::estimator
