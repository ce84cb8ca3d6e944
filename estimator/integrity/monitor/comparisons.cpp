// Who is to blame for what contradicts what.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "estimator/common/time.hpp"
#include "estimator/integrity/monitor/sources.hpp"
#include "estimator/integrity/monitor/testimony.hpp"
#include "estimator/integrity/source_monitor.hpp"

namespace odomd::estimator {
namespace {

using monitor::Contradicted;
using monitor::gap;
using monitor::Interval;
using monitor::seen_speed;
using monitor::slowest_speed;
using monitor::Testimony;
using monitor::wheel_count;
using monitor::wheel_source;
using enum monitor::Turning;

constexpr double look_every_s = monitor::look_every_ns * seconds_per_ns;
constexpr double grip = 6.0;      // [m/s²]: with more to the side the car may be sliding
constexpr double braking = -0.5;  // [m/s²], felt along the way

}  // namespace

/// Wheels that know no sign may turn backwards: then what knows better reads the other way round,
/// and the reading with fewer contradictions counts. No car turns round without a halt, so looks
/// since the last one count, up to a second of them: a sensor that fails does not turn it round.
bool SourceMonitor::goes_backwards(const Testimony& told, int ahead, int backwards) noexcept {
  constexpr int most = 50;
  if (told.speed.largest() < slowest_speed) {
    ahead_rather_ = 0;
  }
  ahead_rather_ = std::clamp(ahead_rather_ + backwards - ahead, -most, most);
  return ahead_rather_ < 0;
}

/// Wheels against each other, and against the camera's speed.
void SourceMonitor::blame_wheels(const Testimony& told, const Contradicted& contradicted) noexcept {
  const auto& found = contradicted.speeds;
  for (std::size_t i = 0; i < monitor::speed_count; ++i) {
    const Source source = i == seen_speed ? Source::camera : wheel_source(i);
    const std::size_t by = found.explained_by(i);
    // Against the camera alone it is one word against another: a slow encoder's steps repeat.
    const bool by_wheels = by > 1 || !found.between(i, seen_speed);
    if (i != seen_speed && by >= 1 && by_wheels && repeats(source) &&
        told.speeds[i].largest() > slowest_speed) {
      suspect(source, SourceFlag::frozen);
    } else if (by >= 2) {
      suspect(source, i != seen_speed   ? SourceFlag::slipping
                      : repeats(source) ? SourceFlag::frozen
                                        : SourceFlag::drifting);
    }
  }
  // A whole axle: the faster one spins, but for the slower one locked under the brake.
  const auto apart = [&](std::size_t front, std::size_t rear) {
    return found.between(front, rear);
  };
  if (apart(0, 2) && apart(0, 3) && apart(1, 2) && apart(1, 3) && !found.between(0, 1) &&
      !found.between(2, 3)) {
    const Interval& felt = told.ahead_felt_shortly;
    const Interval along = told.speed.high < 0.0 ? felt.mirrored() : felt;
    const bool brakes = along.known() && along.high < braking;
    const bool rear_faster = told.speeds[2].largest() > told.speeds[0].largest();
    const std::size_t first = rear_faster != brakes ? 2 : 0;
    suspect(wheel_source(first), SourceFlag::slipping);
    suspect(wheel_source(first + 1), SourceFlag::slipping);
  }
}

/// Everything that knows how the car turns.
void SourceMonitor::blame_turns(const Testimony& told, const Contradicted& contradicted) noexcept {
  const double sideways_before = std::exchange(sideways_, 0.0);
  const auto& found = contradicted.turns;
  if (found.count() == 0) {
    return;
  }
  const auto judge = [&](monitor::Turning member) {
    const Source source = monitor::sources_of(member).front();
    // One word against another: of two that both repeat, neither can be told to be frozen.
    bool against_alive = false;
    for (std::size_t other = 0; other < monitor::turning_count; ++other) {
      const auto [one, another] = monitor::sources_of(static_cast<monitor::Turning>(other));
      against_alive =
          against_alive || (found.between(member, other) && !(repeats(one) && repeats(another)));
    }
    const std::size_t by = found.explained_by(member);
    if (by >= 1 && against_alive && repeats(source)) {
      suspect(source, SourceFlag::frozen);
    } else if (by >= 2) {
      suspect(source, SourceFlag::drifting);
    }
  };
  const double felt = told.sides[by_felt].largest();
  judge(by_gyro);
  // At the limit of grip, or beyond it, the steering does not say how the car turns.
  if (!(told.sides[by_gyro].largest() > grip) && !(felt > grip)) {
    judge(by_steering);
  }
  judge(by_felt);
  judge(by_camera);
  // With the speed of one axle alone: where v ψ̇ is more than what is felt, and the steering (which
  // knows the speed too), the camera or the grip of tyres is against the speed, it is the speed. A
  // car that goes into a spin feels less as well, but only until it moves sideways as fast as it
  // has driven: v̇_y = a_y - v ψ̇.
  const double demanded = gap(told.sides[by_gyro], monitor::exactly(0.0));
  constexpr double never_held = 8.0;  // [m/s²]
  bool camera_says = false;
  for (std::size_t i = 0; i < wheel_count; ++i) {
    camera_says = camera_says || contradicted.speeds.between(i, seen_speed);
  }
  camera_says = camera_says && flag(Source::camera) == SourceFlag::ok;
  const bool too_fast =
      found.between(by_gyro, by_felt) && demanded > felt &&
      ((found.between(by_gyro, by_steering) && found.between(by_steering, by_felt)) ||
       camera_says || demanded > never_held);
  sideways_ = too_fast ? sideways_before + (demanded - felt) * look_every_s : 0.0;
  if (sideways_ > told.speed.largest()) {
    for (const Source source : {Source::wheel_rear, Source::motor}) {
      if (alive(source)) {
        suspect(source, SourceFlag::slipping);
      }
    }
  }
}

/// The accelerometer along the car against what the wheels' speed does.
void SourceMonitor::blame_lengthwise(const Testimony& told) noexcept {
  // A car that slides turns its speed aside, v̇_x = a_x + v_y ψ̇: no wheel slips for that.
  const bool slides = told.sides[by_felt].largest() > grip;
  std::size_t wheels = 0;
  for (std::size_t i = 0; i < wheel_count; ++i) {
    const Source source = wheel_source(i);
    if (alive(source) && evidence_[index_of(source)] == SourceFlag::ok &&
        signal(source).flag == SourceFlag::ok) {
      ++wheels;
    }
  }
  if (repeats(Source::accel_x)) {
    suspect(Source::accel_x, SourceFlag::frozen);
  } else if (wheels >= 3) {
    suspect(Source::accel_x, SourceFlag::drifting);
  } else {
    for (std::size_t i = 0; i < wheel_count; ++i) {
      const Source source = wheel_source(i);
      if (!alive(source)) {
        continue;
      }
      if (repeats(source) && signal(source).value != 0.0) {
        suspect(source, SourceFlag::frozen);
      } else if (!slides &&
                 told.speed_rate.largest() > told.ahead_felt.largest() + lengthwise_error(told)) {
        suspect(source, SourceFlag::slipping);
      }
    }
  }
}

/// A picture that does not change while the car drives on.
void SourceMonitor::watch_camera_pose() noexcept {
  const Signal& camera = signal(Source::camera);
  if (camera.same < 3 || wheels_slip_) {
    return;
  }
  const SeenPose& pose = newest_pose();
  if (way_since_pose_ > std::max(0.1, 6.0 * pose.sigma) ||
      std::abs(turn_since_pose_) > std::max(0.1, 6.0 * pose.sigma_yaw)) {
    suspect(Source::camera, SourceFlag::frozen);
  }
}

}  // namespace odomd::estimator
