// docs/model.md, "Integrity".
#include "estimator/integrity/integrity.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "estimator/common/symmetric3.hpp"
#include "estimator/common/time.hpp"
#include "estimator/integrity/equations.hpp"

namespace odomd::estimator {

using namespace integrity;

namespace {

constexpr double persistence_s = 0.1;
constexpr double frozen_persistence_s = 0.05;
// Duration of agreement before a flag is lowered [s]: for the first failure, and the upper limit.
constexpr std::pair required_s{1.0, 60.0};
constexpr std::pair required_of_wheels_s{0.4, 5.0};
// Fewer negative speeds, each after another of the same wheel, may be corrupt frames.
constexpr int sign_known_after = 3;

/// Adds to a wheel's slip the part of its speed change between two samples that exceeds noise and
/// any car's v̇_x = a_x + v_y ψ̇. A change back ends the slip.
void add_slip(const Observations& observed, std::int64_t time_ns, double value, double sigma,
              SourceHistory& wheel) noexcept {
  const double dt = seconds_between(wheel.time_ns, time_ns);
  const double turning = observed.slid() ? std::abs(observed.speed() * observed.yaw_rate()) : 0.0;
  const double change = value - wheel.value;
  const double excess =
      std::max(std::abs(change) - (largest_accel + turning) * dt - most_sigmas * sigma, 0.0);
  const double slipped = std::copysign(excess, change);
  wheel.slip = wheel.slip * std::exp(-dt / Tuning{}.slip_memory_s) + slipped;
  wheel.new_slip = wheel.new_slip * std::exp(-dt / seconds_of(Over::long_time)) +
                   (observed.seen() ? slipped : 0.0);
}

}  // namespace

void Integrity::add(Source source, std::int64_t time_ns, double value, double sigma,
                    std::int64_t arrival_ns) noexcept {
  SourceHistory& history = observed_.sources[index_of(source)];
  if (history.seen() && time_ns <= history.time_ns) {
    return;
  }
  if (is_wheel(source) && std::max(value, history.value) < -slowest_rolling &&
      observed_.history(Source::direction).value >= 0.0) {
    negative_speeds_ = std::min(negative_speeds_ + 1, sign_known_after);
  }
  if (is_wheel(source) && history.seen()) {
    add_slip(observed_, time_ns, value, sigma, history);
  }
  add_sample(history, time_ns, value, sigma, value == history.value);
  history.arrival_ns = std::max(arrival_ns, time_ns);
}

/// Sigmas by which a camera step exceeds any motion possible after earlier steps.
double Integrity::surprise(const CameraStep& step, const CameraPose& pose) const noexcept {
  const SourceHistory& speed = observed_.camera_speed;
  if (speed.begun < least_samples) {
    return 0.0;
  }
  const double scale = std::sqrt(observed_.errors.camera_noise_scale);
  const double sigma = scale * std::max(pose.sigma_x, pose.sigma_y);
  const double dt = step.dt;
  // v̇_x = a_x + v_y ψ̇
  const double turning = std::abs(step.turned) / dt * last_step_speed_;
  const double ahead = speed.mean() * dt;
  const double change_s = (mean_s.front() + dt) * dt;
  const double off = std::max(
      std::abs(step.along - ahead) - (largest_accel + turning) * change_s,
      std::abs(step.across) - std::abs(step.along) - std::abs(ahead) - largest_accel * change_s);
  const double turned = std::abs(step.turned - observed_.camera_yaw_rate.mean() * dt);
  return std::max(
      {off / sigma, (turned - largest_yaw_accel * change_s) / (scale * pose.sigma_yaw), 0.0});
}

/// Adds the motion between two poses, along the car. Leaves out an outlier, unless the next pose
/// continues its motion: then the map has jumped.
void Integrity::add(const CameraPose& pose) noexcept {
  constexpr double longest_pause_s = 0.5;
  constexpr double shortest_step_s = 0.005;  // several poses of one instant measure no speed
  constexpr double most = 5.0;               // sigmas
  SourceHistory& poses = observed_.sources[index_of(Source::camera)];
  CameraStep step = step_between(reference_pose_, pose);
  if (poses.seen() && (pose.capture_ns <= poses.time_ns || step.dt < shortest_step_s)) {
    return;
  }
  const std::array<double, 3> numbers{pose.x, pose.y, pose.yaw};
  const bool same = std::exchange(newest_pose_, numbers) == numbers;
  bool outlier = false;
  if (!poses.seen() || step.dt >= longest_pause_s) {
    observed_.camera_speed = observed_.camera_yaw_rate = {};
  } else {
    const double off = surprise(step, pose);
    observed_.camera_scatter += step.dt / seconds_of(Over::long_time) *
                                (squared(std::min(off, most)) - observed_.camera_scatter);
    if (off > most) {
      step = step_between(last_outlier_, pose);
      outlier =
          step.dt < shortest_step_s || step.dt >= longest_pause_s || surprise(step, pose) > most;
    }
    if (!outlier) {
      last_step_speed_ = std::hypot(step.along, step.across) / step.dt;
      add_sample(observed_.camera_speed, pose.capture_ns, step.along / step.dt,
                 std::max(pose.sigma_x, pose.sigma_y), same, Prefilter::none);
      add_sample(observed_.camera_yaw_rate, pose.capture_ns, step.turned / step.dt, pose.sigma_yaw,
                 same, Prefilter::none);
    }
  }
  last_outlier_ = outlier ? pose : CameraPose{};
  reference_pose_ = outlier ? reference_pose_ : pose;
  add_sample(poses, pose.capture_ns, 0.0, 0.0, same);
  for (SourceHistory* const history :
       {&poses, &observed_.camera_speed, &observed_.camera_yaw_rate}) {
    history->arrival_ns = std::max(pose.arrival_ns, pose.capture_ns);
  }
}

Sources Integrity::distrusted() const noexcept {
  return set_of([&](Source source) { return !trusted(source); });
}

/// Decides the sign of unsigned wheel speeds. A car reverses only after a halt, so all checks since
/// the last halt vote: a failing sensor does not change the sign. Returns false if the other sign
/// explains more, but has not won yet.
bool Integrity::decide_sign(const Sensors& sensors, Consensus& all, Solution& base) noexcept {
  const SourceHistory& direction = observed_.history(Source::direction);
  if (negative_speeds_ == sign_known_after || direction.value != 0.0) {
    backwards_ = false;
    agreed_.unsigned_distance = 0.0;
    return true;
  }
  if ((all.present() & wheels & ~observed_.distrusted) == 0) {
    return true;
  }
  Observations mirrored = observed_;
  for (Solution& solution : mirrored.last_consensus) {
    solution.motion[of::speed] *= -1.0;
  }
  mirrored.errors.rear_slip = -observed_.errors.rear_slip;
  if (!halted_) {
    mirrored.integrated_speed = -observed_.integrated_speed;  // after a halt its sign is known
  }
  const Consensus reversed = equations(sensors, mirrored, !backwards_, Over::short_time);
  const Solution reversed_base = reversed.without(observed_.distrusted);
  if (std::abs(base.motion[of::speed]) < slowest_rolling) {
    forward_votes_ = 0;
    halted_ = true;
    distance_ = 0.0;
    agreed_.unsettled_distance = agreed_.unsigned_distance;
  }
  const double better = reversed_base.misfit - base.misfit;
  const int vote = std::abs(better) <= gate ? 0 : (better > 0.0) != backwards_ ? 1 : -1;
  forward_votes_ = std::clamp(forward_votes_ + vote, -max_votes, max_votes);
  if (backwards_ != (forward_votes_ < 0)) {
    backwards_ = forward_votes_ < 0;
    agreed_.reversed_distance = std::exchange(distance_, -distance_);
    observed_ = mirrored;
    observed_.integrated_sigma = Observations{}.integrated_sigma;
    for (SourceHistory& history : observed_.sources) {
      restart_means(history);
    }
    all = reversed;
    base = reversed_base;
    return true;
  }
  const double decided = static_cast<double>(std::abs(forward_votes_)) / decisive_votes;
  agreed_.unsigned_distance = halted_ ? std::max(1.0 - decided, 0.0) * distance_ : 0.0;
  return better > -margin || std::abs(forward_votes_) >= decisive_votes;
}

void Integrity::check(const Sensors& sensors, std::int64_t now_ns,
                      const SensorErrors& errors) noexcept {
  if (!is_due(now_ns)) {
    return;
  }
  constexpr double usual_misfit = 8.0;
  constexpr double longest_s = 0.1;
  observed_.errors = errors;
  const std::int64_t before_ns = std::exchange(observed_.now_ns, now_ns);
  const double elapsed_s = before_ns != 0 ? seconds_between(before_ns, now_ns) : 0.0;
  const double dt = std::min(elapsed_s, longest_s);
  const Sources out = observed_.distrusted = distrusted();
  // 1. The integrated speed. Its change in a gap is unknown.
  observed_.integrated_sigma += gravity * (elapsed_s - dt);
  observed_.speed_unknown_s += elapsed_s - dt;
  integrate_acceleration(sensors, observed_, dt, agreed_.wheels_distrusted);
  observed_.spin = std::max(slide_of(errors.rear_slip, observed_.speed(), sensors.car),
                            observed_.spin * std::exp(-elapsed_s / seconds_of(Over::long_time)));
  // 2. The consensus of the trusted sources; if it is contradicted, the sources at fault.
  Consensus all = equations(sensors, observed_, backwards_, Over::short_time);
  Solution base = all.without(out);
  const Sources present = all.present();
  agreed_.reversed_distance = agreed_.unsettled_distance = 0.0;
  const bool sign_known = decide_sign(sensors, all, base);
  const Consensus longer = equations(sensors, observed_, backwards_, Over::long_time);
  Solution longer_base = longer.without(out);
  const bool by_short_mean = base.misfit > gate;
  agreed_.contradicted = by_short_mean || longer_base.misfit > gate;
  const Sources stuck = std::abs(observed_.speed()) > min_learning_speed &&
                                observed_.history(Source::yaw_rate).is_stuck()
                            ? only(Source::yaw_rate)
                            : 0;
  const Sources isolated =
      !sign_known            ? 0
      : by_short_mean        ? isolate_fault(observed_, all, base, agreed_.without_wheels)
      : agreed_.contradicted ? isolate_fault(observed_, longer, longer_base, agreed_.without_wheels)
                             : 0;
  // If turn models contradict a gyro that reads more than the tyres can hold, the car slides.
  // Without a camera that sees the car, the gyro may be at fault instead.
  const double demanded = base.motion[of::speed] * observed_.history(Source::yaw_rate).mean();
  const bool slides = isolated != 0 && (isolated & ~turn_models) == 0 && observed_.seen() &&
                      (std::abs(demanded) > sliding_accel || observed_.slides(now_ns));
  const Sources faulty = (slides ? 0 : isolated) | (stuck & ~out);
  raise_flags(faulty, !by_short_mean);
  agreed_.contradicted = agreed_.contradicted && (faulty | isolated) == 0;
  agreed_.camera_inconsistent = camera_innovations_.contradicted();
  if (!agreed_.contradicted) {
    agreed_.contradicted_since_ns = now_ns;
  }
  if ((faulty | isolated) != 0) {
    base = all.without(out | faulty | isolated);
    longer_base = longer.without(out | faulty | isolated);
  }
  // 3. The result, and learning from it.
  if (suspected_ == 0 && distrusted() == 0 && !agreed_.contradicted) {
    learn_radii(longer, longer_base, dt, observed_);
  }
  const Sources speed_sources = wheels | only(Source::camera) | only(Source::accel_x);
  observed_.speed_unknown_s =
      (present & ~(out | faulty) & speed_sources) != 0 ? 0.0 : observed_.speed_unknown_s + dt;
  base.sigma *= std::sqrt(std::max(1.0, base.misfit / usual_misfit));
  distance_ += dt * base.motion[of::speed];
  observed_.last_consensus = {base, longer_base};
  agreed_.without_gyro = all.without(out | faulty | only(Source::yaw_rate));
  agreed_.without_wheels = all.without(out | faulty | wheels);
  const Sources trusted = ~distrusted();
  // A source that pauses has not failed.
  const Sources lately = set_of([&](Source source) {
    constexpr double pause_s = 0.5;
    const SourceHistory& history = observed_.history(source);
    return history.seen() && seconds_between(history.time_ns, now_ns) <= pause_s;
  });
  const auto all_distrusted = [&](Sources sources) {
    return (present & sources) != 0 && (lately & sources & trusted) == 0;
  };
  agreed_.wheels_distrusted = all_distrusted(wheels);
  // The car may slide at a high lateral acceleration, while an axle slips or the rear axle moves
  // sideways, and afterwards while it yaws faster than any steering angle allows.
  const double largest_yaw_rate =
      std::abs(observed_.speed()) * sensors.tuning.sharpest_turn / sensors.car.wheelbase();
  const bool spins = observed_.slides(now_ns, Over::long_time) &&
                     std::abs(observed_.yaw_rate()) > largest_yaw_rate + largest_gyro_bias;
  if (slides || spins) {
    observed_.slid_ns = now_ns;
  }
  const bool aside =
      std::abs(errors.rear_slip) > sensors.tuning.sliding_slip * std::abs(observed_.speed()) +
                                       most_sigmas * errors.rear_slip_sigma;
  if (lateral_accel(observed_, Over::short_time) > sliding_accel || all_distrusted(front_wheels) ||
      all_distrusted(rear_wheels) || slides || spins || aside) {
    observed_.last_slide_ns = now_ns;
  }
  if ((present & trusted & (wheels | only(Source::camera))) != 0) {
    follow_consensus(observed_, dt, agreed_.contradicted,
                     suspected_ == 0 && (~trusted & (wheels | only(Source::accel_x))) == 0);
  }
  for (const Source source : all_sources) {
    Trust& trust = trust_[index_of(source)];
    if (contains(trusted, source)) {
      trust.required_s -= dt / required_s.second * trust.required_s;
    } else {
      const Sources others = (out | faulty) & ~only(source);
      const double short_increase = all.without(others).misfit - base.misfit;
      const double long_increase = longer.without(others).misfit - longer_base.misfit;
      lower_flag(source,
                 trust.by_long_mean ? std::max(short_increase, long_increase) : short_increase, dt);
    }
  }
}

/// Flags the suspects once they have been suspected for long enough.
void Integrity::raise_flags(Sources suspects, bool by_long_mean) noexcept {
  if ((suspects & suspected_) == 0) {
    suspected_since_ns_ = observed_.now_ns;
  }
  suspected_ = suspects;
  const double elapsed_s = seconds_between(suspected_since_ns_, observed_.now_ns);
  for (const Source source : all_sources) {
    const bool wheel = is_wheel(source);
    const bool frozen = observed_.repeats(source);
    if (contains(suspects, source) &&
        elapsed_s >= (frozen || wheel ? frozen_persistence_s : persistence_s)) {
      Trust& trust = trust_[index_of(source)];
      if (trust.flag == SourceFlag::ok) {
        trust.raised_ns = observed_.now_ns;
        trust.by_long_mean = by_long_mean;
        // A source that fails again has to agree for longer.
        const auto [first_s, longest_s] = wheel ? required_of_wheels_s : required_s;
        trust.required_s = std::clamp(2.0 * trust.required_s, first_s, longest_s);
      }
      trust.flag = frozen  ? SourceFlag::frozen
                   : wheel ? SourceFlag::slipping
                           : SourceFlag::drifting;
      trust.agreed_s = 0.0;
    }
  }
}

/// Lowers a flag once the source has agreed with the others for long enough. `misfit` is the
/// source's addition to the others' misfit. On a straight, sensors of turns count less.
void Integrity::lower_flag(Source source, double misfit, double dt) noexcept {
  constexpr Sources of_turns = turn_models | only(Source::yaw_rate) | only(Source::camera);
  constexpr double slowest_turn = 0.1;  // [rad/s]
  constexpr double without_turn = 0.2;
  Trust& trust = trust_[index_of(source)];
  SourceHistory& history = observed_.sources[index_of(source)];
  if (trust.flag == SourceFlag::drifting && observed_.repeats(source)) {
    trust.flag = SourceFlag::frozen;
  }
  const bool still = trust.flag == SourceFlag::frozen && history.same_since_ns < trust.raised_ns;
  if (misfit > squared(most_sigmas) || still || !history.alive(observed_.now_ns)) {
    trust.agreed_s = 0.0;
    return;
  }
  const bool conclusive =
      !contains(of_turns, source) || std::abs(observed_.yaw_rate()) > slowest_turn;
  trust.agreed_s += conclusive ? dt : without_turn * dt;
  if (trust.agreed_s >= trust.required_s) {
    trust.flag = SourceFlag::ok;
    restart_means(history);
    if (source == Source::camera) {
      restart_means(observed_.camera_speed);
      restart_means(observed_.camera_yaw_rate);
    }
  }
}

}  // namespace odomd::estimator
