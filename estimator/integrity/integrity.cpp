// docs/model.md, "Integrity".
#include "estimator/integrity/integrity.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "estimator/common/pose.hpp"
#include "estimator/common/time.hpp"
#include "estimator/integrity/felt_speed.hpp"
#include "estimator/integrity/hypotheses.hpp"
#include "estimator/integrity/wheel_radii.hpp"

namespace odomd::estimator {
namespace {

using integrity::Consensus;
using integrity::contains;
using integrity::front_wheels;
using integrity::gate;
using integrity::margin;
using integrity::rear_wheels;
using integrity::wheels;

using integrity::only;
using integrity::Over;
using integrity::slowest_learning;
using integrity::Solution;
using integrity::Sources;
namespace of = integrity::of;

constexpr std::int64_t look_every_ns = 20'000'000;

constexpr double lasts_s = 0.1;
constexpr double frozen_lasts_s = 0.05;
// A source that was at fault must agree for so long [s], at first and at most; a slip is no
// failure.
constexpr std::pair calm_s{1.0, 60.0};
constexpr std::pair calm_of_wheels_s{0.4, 5.0};
constexpr double forgiven_s = 60.0;
// No car turns in faster [rad/s²].
constexpr double quickest_turn_in = 30.0;
// So many negative speeds are no corrupt telegram.
constexpr int sign_known_after = 3;

/// The most that a motion changes a sensor by, from one sample to the next.
double largest_change(Source source, double value, double elapsed_s) noexcept {
  constexpr double at_once = 0.2;  // [m/s], and of the speed: steps of an encoder, kerbs
  constexpr double share = 0.1;
  return is_wheel(source) ? at_once + share * std::abs(value) + 2.0 * gravity * elapsed_s : 1e9;
}

}  // namespace

void Integrity::hear(Source source, std::int64_t time_ns, double value, double sigma,
                     std::int64_t heard_ns) noexcept {
  integrity::Witness& witness = heard_.sources[index_of(source)];
  if (witness.seen && time_ns <= witness.time_ns) {
    return;
  }
  if (is_wheel(source) && value < 0.0 && heard_.by(Source::direction).value >= 0.0) {
    negative_speeds_ = std::min(negative_speeds_ + 1, sign_known_after);
  }
  integrity::hear(witness, time_ns, value, sigma, value == witness.value,
                  largest_change(source, witness.value, seconds_between(witness.time_ns, time_ns)));
  witness.heard_ns = std::max(heard_ns, time_ns);
}

/// The way between two poses, along the car. One pose that strays is left out; where the next does,
/// too, the map has jumped, which is no motion.
void Integrity::hear(const CameraPose& pose) noexcept {
  constexpr double longest_pause_s = 0.5;
  integrity::Witness& seen = heard_.sources[index_of(Source::camera)];
  if (seen.seen && pose.capture_ns <= seen.time_ns) {
    return;
  }
  const auto [x, y, yaw] = std::exchange(newest_pose_, {pose.x, pose.y, pose.yaw});
  const bool same = pose.x == x && pose.y == y && pose.yaw == yaw;
  const double dt = seconds_between(seen_from_.capture_ns, pose.capture_ns);
  bool strays = false;
  if (seen.seen && dt < longest_pause_s) {
    const double turned = wrap_angle(pose.yaw - seen_from_.yaw);
    const double middle = seen_from_.yaw + 0.5 * turned;
    const double way =
        (pose.x - seen_from_.x) * std::cos(middle) + (pose.y - seen_from_.y) * std::sin(middle);
    const double sigma = std::max(pose.sigma_x, pose.sigma_y);
    const auto is_motion = [&](const integrity::Witness& lately, double by, double noise,
                               double rate) {
      constexpr double sigmas = 8.0;
      const double most = sigmas * std::sqrt(heard_.known.camera_unrest) * noise +
                          rate * (integrity::mean_s.front() + dt) * dt;
      return !lately.seen || std::abs(by - lately.mean() * dt) <= most;
    };
    strays = !is_motion(heard_.seen_speed, way, sigma, 1.5 * gravity) ||
             !is_motion(heard_.seen_turn, turned, pose.sigma_yaw, quickest_turn_in);
    if (!strays) {
      const auto counts = integrity::Single::counts;
      integrity::hear(heard_.seen_speed, pose.capture_ns, way / dt, sigma, same, 1e9, counts);
      integrity::hear(heard_.seen_turn, pose.capture_ns, turned / dt, pose.sigma_yaw, same, 1e9,
                      counts);
    }
  }
  const bool jumps = strays && strayed_;
  strayed_ = strays && !jumps;
  if (!strayed_) {
    seen_from_ = pose;
  }
  integrity::hear(seen, pose.capture_ns, 0.0, 0.0, same, 1e9);
  for (integrity::Witness* const witness : {&seen, &heard_.seen_speed, &heard_.seen_turn}) {
    witness->heard_ns = std::max(pose.arrival_ns, pose.capture_ns);
  }
}

Sources Integrity::distrusted() const noexcept {
  Sources all = 0;
  for (std::size_t i = 0; i < source_count; ++i) {
    all |= trust_[i].flag != SourceFlag::ok ? Sources{1} << i : 0;
  }
  return all;
}

/// Wheels that know no sign may turn backwards. No car turns round without a halt, so what was seen
/// since the last one counts: a sensor that fails does not turn it round. False: the other way
/// explains more, but not yet for long enough.
bool Integrity::settle_sign(const integrity::Sensors& sensors, Consensus& all,
                            Solution& base) noexcept {
  constexpr double slowest = 0.1;  // [m/s]
  const integrity::Witness& direction = heard_.by(Source::direction);
  if (negative_speeds_ == sign_known_after ||
      (direction.alive(looked_ns_) && direction.value != 0.0)) {
    backwards_ = false;
    return true;
  }
  if ((heard_now_ & wheels & ~distrusted()) == 0) {
    return true;
  }
  integrity::Heard mirrored = heard_;
  for (double& speed : mirrored.speeds) {
    speed = -speed;
  }
  if (!halted_) {
    mirrored.felt_speed = -heard_.felt_speed;  // it only knows the way since a halt
  }
  const Consensus otherwise = parities(sensors, mirrored, !backwards_, Over::short_time);
  const Solution turned = otherwise.without(distrusted());
  if (std::abs(base.motion[of::speed]) < slowest) {
    ahead_rather_ = 0;
    halted_ = true;
    way_ = 0.0;
  }
  const double better = turned.misfit - base.misfit;
  const int rather = std::abs(better) <= gate ? 0 : (better > 0.0) != backwards_ ? 1 : -1;
  ahead_rather_ = std::clamp(ahead_rather_ + rather, -most_looks, most_looks);
  if (backwards_ != (ahead_rather_ < 0)) {
    backwards_ = ahead_rather_ < 0;
    agreed_.way_back = std::exchange(way_, -way_);
    heard_ = mirrored;
    heard_.felt_sigma = integrity::Heard{}.felt_sigma;
    for (integrity::Witness& witness : heard_.sources) {
      integrity::begin_anew(witness);
    }
    all = otherwise;
    base = turned;
    return true;
  }
  return better > -margin || std::abs(ahead_rather_) >= settled_looks;
}

void Integrity::look(const integrity::Sensors& sensors, std::int64_t now_ns) noexcept {
  constexpr double usual = 8.0;  // misfit
  constexpr double longest_s = 0.1;
  constexpr std::int64_t slack_ns = 1'000'000;
  if (looked_ns_ != 0 && ns_between(looked_ns_, now_ns) < look_every_ns - slack_ns) {
    return;
  }
  const double elapsed_s = looked_ns_ != 0 ? seconds_between(looked_ns_, now_ns) : 0.0;
  const double dt = std::min(elapsed_s, longest_s);
  looked_ns_ = heard_.now_ns = now_ns;
  const Sources out = distrusted();
  heard_.out = out;
  // 1. What was not looked at may have changed the speed.
  heard_.felt_sigma += gravity * (elapsed_s - dt);
  heard_.untold_s += elapsed_s - dt;
  const bool felt = heard_.tells(Source::accel_x);
  if (felt) {
    feel(sensors, heard_, dt);
    if (agreed_.wheels_out) {
      rest_with_locked_wheels(heard_);
    } else {
      heard_.rests_since_ns = now_ns;
    }
  } else {
    heard_.felt_sigma += gravity * dt;
  }
  // 2. What they agree on, or whose absence would make them.
  Consensus all = parities(sensors, heard_, backwards_, Over::short_time);
  Solution base = all.without(out);
  heard_now_ = 0;
  for (const integrity::Row& row : all) {
    heard_now_ |= row.sources;
  }
  agreed_.way_back = 0.0;
  const bool sign_known = settle_sign(sensors, all, base);
  const Consensus longer = parities(sensors, heard_, backwards_, Over::long_time);
  Solution longer_base = longer.without(out);
  const bool soon = base.misfit > gate;
  agreed_.contradicted = soon || longer_base.misfit > gate;
  const integrity::WithoutWheels without_wheels{agreed_.speed_without_wheels,
                                                agreed_.speed_without_wheels_sigma};
  const auto suspects = [&](const Consensus& rows, const Solution& solution) {
    return integrity::suspects(heard_, rows, solution, out, without_wheels);
  };
  const Sources blamed = !sign_known            ? 0
                         : soon                 ? suspects(all, base)
                         : agreed_.contradicted ? suspects(longer, longer_base)
                                                : 0;
  accuse(blamed, !soon);
  if (!agreed_.contradicted || blamed != 0) {
    agreed_.contradicted_since_ns = now_ns;
  }
  if (blamed != 0) {
    agreed_.contradicted = false;
    base = all.without(out | blamed);
    longer_base = longer.without(out | blamed);
  }
  // 3. What it is, and what is learnt of it.
  if (suspected_ == 0 && distrusted() == 0 && !agreed_.contradicted) {
    learn_radii(sensors, longer, longer_base, dt, heard_);
  }
  const Sources tellers = wheels | only(Source::camera) | only(Source::accel_x);
  heard_.untold_s = (heard_now_ & ~(out | blamed) & tellers) != 0 ? 0.0 : heard_.untold_s + dt;
  const double stretch = std::sqrt(std::max(1.0, base.misfit / usual));
  way_ += dt * base.motion[of::speed];
  heard_.speeds = {base.motion[of::speed], longer_base.motion[of::speed]};
  heard_.turns = {base.motion[of::turn], longer_base.motion[of::turn]};
  heard_.speed_sigma = stretch * base.sigma[of::speed];
  agreed_.speed = heard_.speed();
  agreed_.speed_sigma = heard_.speed_sigma;
  agreed_.turn = heard_.turn();
  agreed_.turn_sigma = stretch * base.sigma[of::turn];
  const Solution no_gyro = all.without(out | blamed | only(Source::yaw_rate));
  agreed_.turn_without_gyro = no_gyro.motion[of::turn];
  agreed_.turn_without_gyro_sigma = no_gyro.sigma[of::turn];
  const Solution no_wheels = all.without(out | blamed | wheels);
  agreed_.speed_without_wheels = no_wheels.motion[of::speed];
  agreed_.speed_without_wheels_sigma = no_wheels.sigma[of::speed];
  const Sources wheels_heard = wheels & heard_now_;
  agreed_.wheels_out = wheels_heard != 0 && (wheels_heard & ~distrusted()) == 0;
  // Tyres that push to the limit slide, and those that slip along; and a car that slid does so as
  // long as it turns round faster than any steering lets it.
  constexpr double sharpest = 0.55;  // tan δ
  constexpr double slid_for_s = 0.24;
  const auto slips = [&](Sources axle) {
    return (heard_now_ & axle) != 0 && (heard_now_ & axle & ~distrusted()) == 0;
  };
  const double rolls = std::abs(heard_.speed()) * sharpest / sensors.car.wheelbase();
  const bool spins = heard_.slides(now_ns, slid_for_s) &&
                     std::abs(heard_.turn()) > rolls + integrity::largest_gyro_bias;
  if (side_push(heard_, Over::short_time) > integrity::limit || slips(front_wheels) ||
      slips(rear_wheels) || spins) {
    heard_.slid_ns = now_ns;
  }
  const Sources told = ~distrusted();
  follow(heard_, dt,
         {.felt = felt,
          .told = (heard_now_ & told & (wheels | only(Source::camera))) != 0,
          .contradicted = agreed_.contradicted,
          .sound = suspected_ == 0 && (~told & (wheels | only(Source::accel_x))) == 0});
  for (std::size_t i = 0; i < source_count; ++i) {
    const Sources it = Sources{1} << i;
    if (trust_[i].flag != SourceFlag::ok) {
      const Sources others = (out | blamed) & ~it;
      const double soon_more = all.without(others).misfit - base.misfit;
      const double longer_more = longer.without(others).misfit - longer_base.misfit;
      trust_again(i, trust_[i].slowly ? std::max(soon_more, longer_more) : soon_more, dt);
    } else {
      trust_[i].calm_s -= dt / forgiven_s * trust_[i].calm_s;
    }
  }
}

/// Evidence that lasts becomes a flag.
void Integrity::accuse(Sources suspects, bool slowly) noexcept {
  if ((suspects & suspected_) == 0) {
    suspected_since_ns_ = looked_ns_;
  }
  suspected_ = suspects;
  for (std::size_t i = 0; i < source_count; ++i) {
    if (!contains(suspects, i)) {
      continue;
    }
    const bool wheel = is_wheel(static_cast<Source>(i));
    const bool frozen = heard_.sources[i].repeats();
    const double elapsed_s = seconds_between(suspected_since_ns_, looked_ns_);
    if (elapsed_s >= (frozen || wheel ? frozen_lasts_s : lasts_s)) {
      Trust& trust = trust_[i];
      if (trust.flag == SourceFlag::ok) {
        trust.raised_ns = looked_ns_;
        // The same again: it takes longer to be trusted.
        trust.slowly = slowly;
        const auto [first_s, longest_s] = wheel ? calm_of_wheels_s : calm_s;
        trust.calm_s = std::clamp(2.0 * trust.calm_s, first_s, longest_s);
      }
      trust.flag = frozen  ? SourceFlag::frozen
                   : wheel ? SourceFlag::slipping
                           : SourceFlag::drifting;
      trust.agreed_s = 0.0;
    }
  }
}

/// A flag goes when what the source says has agreed with the others for a while: by `misfit` that
/// comes with it. Of a turn it says little as long as there is none.
void Integrity::trust_again(std::size_t source, double misfit, double dt) noexcept {
  constexpr double agrees = 9.0;
  constexpr Sources of_turns = only(Source::yaw_rate) | only(Source::accel_y) |
                               only(Source::steering) | only(Source::camera);
  constexpr double slowest_turn = 0.1;  // [rad/s]
  constexpr double without_turn = 0.2;
  Trust& trust = trust_[source];
  if (trust.flag == SourceFlag::drifting && heard_.sources[source].repeats()) {
    trust.flag = SourceFlag::frozen;
  }
  const bool still =
      trust.flag == SourceFlag::frozen && heard_.sources[source].same_since_ns < trust.raised_ns;
  if (misfit > agrees || still || !heard_.sources[source].alive(looked_ns_)) {
    trust.agreed_s = 0.0;
    return;
  }
  const bool tells = !contains(of_turns, source) || std::abs(heard_.turn()) > slowest_turn;
  trust.agreed_s += tells ? dt : without_turn * dt;
  if (trust.agreed_s >= trust.calm_s) {
    trust.flag = SourceFlag::ok;
    integrity::begin_anew(heard_.sources[source]);
    if (source == index_of(Source::camera)) {
      integrity::begin_anew(heard_.seen_speed);
      integrity::begin_anew(heard_.seen_turn);
    }
  }
}

}  // namespace odomd::estimator
