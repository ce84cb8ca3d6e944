// Which sources contradict each other, and whose fault it is.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "estimator/monitor/contradictions.hpp"
#include "estimator/monitor/sources.hpp"
#include "estimator/source_monitor.hpp"
#include "estimator/time.hpp"

namespace odomd::estimator {
namespace {

using monitor::camera_span_s;
using monitor::Contradictions;
using monitor::gap;
using monitor::Interval;
using monitor::wheel_count;
using monitor::wheel_source;

constexpr double look_every_s = monitor::look_every_ns * seconds_per_ns;
constexpr double grip = 6.0;           // [m/s²]: with more to the side the car may be sliding
constexpr double slowest_speed = 0.1;  // [m/s]: below, the car may as well stand

/// What knows how the car turns.
enum Turning : std::size_t { gyro, steering, rear, front, felt, camera, turnings };

/// Whose samples it is made of: of one source, or of both wheels of an axle.
constexpr std::array<Source, 2> sources_of(Turning turning) noexcept {
  switch (turning) {
    case gyro:
      return {Source::yaw_rate, Source::yaw_rate};
    case steering:
      return {Source::steering, Source::steering};
    case rear:
      return {Source::wheel_rear_left, Source::wheel_rear_right};
    case front:
      return {Source::wheel_front_left, Source::wheel_front_right};
    case felt:
      return {Source::accel_y, Source::accel_y};
    case camera:
    case turnings:
      break;
  }
  return {Source::camera, Source::camera};
}

}  // namespace

/// Wheels against each other, and against the camera's speed.
void SourceMonitor::compare_wheels(std::size_t rows) noexcept {
  constexpr std::size_t members = wheel_count + 1;
  std::array<Interval, members> v{};
  for (std::size_t i = 0; i < members; ++i) {
    // The camera's speed is a mean over some time before now.
    v[i] = history_.over(first_wheel + i, i == wheel_count ? 2 : rows);
  }
  const std::size_t camera = wheel_count;
  Contradictions<members> contradictions;
  for (std::size_t i = 0; i < members; ++i) {
    for (std::size_t j = i + 1; j < members; ++j) {
      const double fastest = std::max(v[i].largest(), v[j].largest());
      const auto noise = [&](std::size_t k) {
        return k == camera ? 5.0 * 1.4 * newest_pose().sigma / 0.2
                           : 3.0 * sigma_[index_of(wheel_source(k))];
      };
      if (gap(v[i], v[j]) > 0.12 + 0.12 * fastest + noise(i) + noise(j)) {
        contradictions.add(i, j);
      }
    }
  }
  for (std::size_t i = 0; i < members; ++i) {
    const Source source = i == camera ? Source::camera : wheel_source(i);
    const std::size_t by = contradictions.explained_by(i);
    // Against the camera alone it is one word against another: a slow encoder's steps repeat.
    const bool by_wheels = by > 1 || !contradictions.between(i, camera);
    if (i != camera && by >= 1 && by_wheels && repeats(source) && v[i].largest() > slowest_speed) {
      suspect(source, SourceFlag::frozen);
    } else if (by >= 2) {
      suspect(source, i != camera       ? SourceFlag::slipping
                      : repeats(source) ? SourceFlag::frozen
                                        : SourceFlag::drifting);
    }
  }
  camera_contradicts_wheels_ = false;
  for (std::size_t i = 0; i < camera; ++i) {
    camera_contradicts_wheels_ = camera_contradicts_wheels_ || contradictions.between(i, camera);
  }
  // A whole axle: the faster one spins, but for the slower one locked under the brake.
  const auto apart = [&](std::size_t front, std::size_t rear) {
    return contradictions.between(front, rear);
  };
  if (apart(0, 2) && apart(0, 3) && apart(1, 2) && apart(1, 3) && !contradictions.between(0, 1) &&
      !contradictions.between(2, 3)) {
    const Interval felt = history_.over(ahead_felt, rows);
    const bool braking = felt.known() && felt.high < -0.5;
    const bool rear_faster = v[2].largest() > v[0].largest();
    const std::size_t first = rear_faster != braking ? 2 : 0;
    suspect(wheel_source(first), SourceFlag::slipping);
    suspect(wheel_source(first + 1), SourceFlag::slipping);
  }
}

/// Everything that knows how the car turns.
void SourceMonitor::compare_turns(std::size_t rows, std::size_t camera_rows) noexcept {
  const double sideways_before = std::exchange(sideways_, 0.0);
  const Interval v = history_.over(speed, rows);
  if (!v.known() || v.largest() < slowest_speed) {
    return;
  }
  const double fastest = v.largest();
  const auto turn = [&](std::size_t column) { return history_.over(column, rows); };
  const Interval g = turn(turn_by_gyro);
  const Interval long_g = history_.over(turn_by_gyro, camera_rows);
  const Interval s = turn(turn_by_steering);
  const Interval r = turn(turn_by_rear_wheels);
  const Interval f = turn(turn_by_front_wheels);
  const Interval c = history_.over(turn_by_camera, 2);
  const Interval side_g = turn(side_by_gyro);
  const Interval side_s = turn(side_by_steering);
  const Interval side_r = turn(side_by_rear_wheels);
  const Interval a = turn(side_felt);

  const double wheel_sigma = sigma_[index_of(Source::wheel_rear_left)];
  const double steering_error = std::max(3.0 * sigma_[index_of(Source::steering)], 0.01);
  const double error_g = 0.05 + 2.0 * sigma_[index_of(Source::yaw_rate)];
  const double error_s = 0.03 + steering_error * fastest / car_.wheelbase();
  const double error_w = (2.0 * wheel_sigma + 0.012 * fastest) / car_.track_width;
  const double error_c = 0.05 + 5.0 * 1.4 * newest_pose().sigma_yaw / camera_span_s;
  const double error_a = 1.2 + sigma_[index_of(Source::accel_y)];
  constexpr double share = 0.12;

  const auto compare = [&](const Interval& g_, const Interval& long_g_, const Interval& side_g_) {
    Contradictions<turnings> found;
    const auto check = [&](std::size_t i, const Interval& a_, std::size_t j, const Interval& b_,
                           double error) {
      if (gap(a_, b_) > error + share * std::max(a_.largest(), b_.largest())) {
        found.add(i, j);
      }
    };
    check(gyro, g_, steering, s, error_g + error_s);
    check(gyro, g_, rear, r, error_g + error_w);
    check(gyro, g_, front, f, error_g + error_w);
    check(gyro, long_g_, camera, c, error_g + error_c);
    check(steering, s, rear, r, error_s + error_w);
    check(steering, s, front, f, error_s + error_w);
    check(rear, r, front, f, 2.0 * error_w);
    check(steering, history_.over(turn_by_steering, camera_rows), camera, c, error_s + error_c);
    check(rear, history_.over(turn_by_rear_wheels, camera_rows), camera, c, error_w + error_c);
    check(gyro, side_g_, felt, a, error_a + fastest * error_g);
    check(steering, side_s, felt, a, error_a + fastest * error_s);
    check(rear, side_r, felt, a, error_a + fastest * error_w);
    return found;
  };
  Contradictions<turnings> found = compare(g, long_g, side_g);
  if (!reversed_seen_ && found.count() > 0) {
    // Wheels that know no sign may as well turn backwards: then everything else is mirrored.
    const Contradictions<turnings> mirrored =
        compare(g.mirrored(), long_g.mirrored(), side_g.mirrored());
    if (mirrored.count() < found.count()) {
      found = mirrored;
    }
  }
  if (found.count() == 0) {
    return;
  }

  const auto judge = [&](Turning member) {
    const Source source = sources_of(member).front();
    // One word against another: of two that both repeat, neither can be told to be frozen.
    bool against_alive = false;
    for (std::size_t other = 0; other < turnings; ++other) {
      const auto [one, another] = sources_of(static_cast<Turning>(other));
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
  judge(gyro);
  // At the limit of grip, or beyond it, the steering does not say how the car turns.
  if (!(side_g.largest() > grip) && !(a.largest() > grip)) {
    judge(steering);
  }
  judge(felt);
  judge(camera);
  // With the speed of one axle alone: where v ψ̇ is more than what is felt, and the steering (which
  // knows the speed too), the camera or the grip of tyres is against the speed, it is the speed. A
  // car that goes into a spin feels less as well, but only until it moves sideways as fast as it
  // has driven: v̇_y = a_y - v ψ̇.
  const double demanded = gap(side_g, monitor::exactly(0.0));
  constexpr double never_held = 8.0;  // [m/s²]
  const bool camera_says = camera_contradicts_wheels_ && flag(Source::camera) == SourceFlag::ok;
  const bool too_fast = found.between(gyro, felt) && demanded > a.largest() &&
                        ((found.between(gyro, steering) && found.between(steering, felt)) ||
                         camera_says || demanded > never_held);
  sideways_ = too_fast ? sideways_before + (demanded - a.largest()) * look_every_s : 0.0;
  if (sideways_ > fastest) {
    for (const Source source : {Source::wheel_rear, Source::motor}) {
      if (alive(source)) {
        suspect(source, SourceFlag::slipping);
      }
    }
  }
}

/// The accelerometer along the car against what the wheels' speed does.
void SourceMonitor::compare_lengthwise(std::size_t rows) noexcept {
  const Interval felt = history_.over(ahead_felt, rows);
  const Interval rate = history_.over(speed_rate, rows);
  if (!felt.known() || !rate.known()) {
    return;
  }
  // A car that slides turns its speed aside, v̇_x = a_x + v_y ψ̇: no wheel slips for that.
  const bool slides = history_.over(side_felt, rows).largest() > grip;
  const double error =
      1.5 + sigma_[index_of(Source::accel_x)] + 0.2 * std::max(felt.largest(), rate.largest());
  if (!(gap(felt, rate) > error)) {
    return;
  }
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
      } else if (!slides && rate.largest() > felt.largest() + error) {
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
