// What every source says of the motion, as the source monitor compares it.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "estimator/common/pose.hpp"
#include "estimator/common/time.hpp"
#include "estimator/integrity/monitor/sources.hpp"
#include "estimator/integrity/source_monitor.hpp"

namespace odomd::estimator {
namespace {

using monitor::camera_span_s;
using monitor::Interval;
using monitor::look_every_ns;
using monitor::wheel_count;
using monitor::wheel_source;

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

double median(std::array<double, wheel_count>& values, std::size_t count) noexcept {
  std::sort(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(count));
  return 0.5 * (values[(count - 1) / 2] + values[count / 2]);
}

}  // namespace

/// What every source says of the motion now.
void SourceMonitor::look() noexcept {
  History::Row row{};
  const auto value = [this](Source source) {
    return alive(source) ? signal(source).value : unknown;
  };
  const bool reverse = alive(Source::direction) && signal(Source::direction).value < 0.0;
  const double gyro = value(Source::yaw_rate);
  const double delta = value(Source::steering);
  // Where the wheels' places are allowed for, one wrong sensor must not make the wheels wrong.
  std::array<double, wheel_count> turns{};
  std::size_t turn_count = 0;
  for (const Column column : {turn_by_gyro, turn_by_steering, turn_by_rear_wheels}) {
    const Interval& before = history_.at(0)[column];
    if (before.known()) {
      const double sign = column == turn_by_gyro && backwards_ ? -1.0 : 1.0;
      turns[turn_count++] = sign * 0.5 * (before.low + before.high);
    }
  }
  const double turn = turn_count == 3 ? median(turns, 3) : turn_count > 0 ? turns[0] : 0.0;
  const double half_track = 0.5 * car_.track_width;
  const double wheelbase = car_.wheelbase();

  // 1. v_x by every wheel: beside the centre line the turn comes on top; a front wheel also moves
  //    sideways with l ψ̇, v_x² = v² - (l ψ̇)².
  std::array<double, wheel_count> speeds{};
  std::size_t count = 0;
  std::size_t trusted = 0;
  std::array<double, wheel_count> trusted_speeds{};
  for (std::size_t i = 0; i < wheel_count; ++i) {
    const Source source = wheel_source(i);
    double v = value(source);
    if (std::isnan(v)) {
      continue;
    }
    v = reverse ? -std::abs(v) : v;
    const bool left = source == Source::wheel_front_left || source == Source::wheel_rear_left;
    const bool right = source == Source::wheel_front_right || source == Source::wheel_rear_right;
    v += left ? half_track * turn : right ? -half_track * turn : 0.0;
    if (source <= Source::wheel_front_right) {
      v = std::copysign(std::sqrt(std::max(0.0, v * v - wheelbase * turn * wheelbase * turn)), v);
    }
    row[first_wheel + i] = monitor::exactly(v);
    speeds[count++] = v;
    if (signal(source).flag == SourceFlag::ok) {
      trusted_speeds[trusted++] = v;
    }
  }
  if (trusted > 0) {
    row[speed] = monitor::exactly(median(trusted_speeds, trusted));
  } else if (count > 0) {
    row[speed] = monitor::exactly(median(speeds, count));
  }
  const double v = row[speed].low;

  // 2. ψ̇ by gyro, by steering between the understeer of an ice rink and none at all, by the
  //    difference of two wheels of an axle.
  if (!std::isnan(gyro)) {
    row[turn_by_gyro] = monitor::exactly(gyro);
  }
  if (!std::isnan(delta) && !std::isnan(v)) {
    // From here on the front may slide [m/s²]; a driver who loses the car does not hold still.
    const double sliding = repeats(Source::steering) ? 5.0 : 2.5;
    const double c_v = car_.cornering_stiffness_front;
    const double c_h = car_.cornering_stiffness_rear;
    const double gradient =
        car_.mass * (car_.rear_axle * c_h - car_.front_axle * c_v) / (wheelbase * c_v * c_h);
    const double most = v * std::tan(delta) /
                        std::max(0.5 * wheelbase, wheelbase + std::min(gradient, 0.0) * v * v);
    const double least = v * std::tan(delta) / (wheelbase + 1.5 * std::max(gradient, 0.0) * v * v);
    row[turn_by_steering] = monitor::between(most, std::abs(v * most) > sliding ? 0.0 : least);
    row[side_by_steering] =
        monitor::between(v * row[turn_by_steering].low, v * row[turn_by_steering].high);
  }
  if (!wheels_slip_) {
    const auto turn_by = [&](Source left, Source right) {
      const double difference = value(right) - value(left);
      if (std::isnan(difference)) {
        return Interval{};
      }
      // Unsigned speeds in reverse
      const double sign = reverse && value(left) > 0.0 ? -1.0 : 1.0;
      return monitor::exactly(sign * difference / car_.track_width);
    };
    row[turn_by_rear_wheels] = turn_by(Source::wheel_rear_left, Source::wheel_rear_right);
    row[turn_by_front_wheels] = turn_by(Source::wheel_front_left, Source::wheel_front_right);
  }
  // 3. ψ̇ and v_x by the camera, over a fifth of a second.
  if (alive(Source::camera) && pose_count_ > 1) {
    const SeenPose& newest = poses_[(pose_count_ - 1) % poses_.size()];
    for (std::size_t age = 1; age < std::min(pose_count_, poses_.size()); ++age) {
      const SeenPose& older = poses_[(pose_count_ - 1 - age) % poses_.size()];
      const double dt = seconds_between(older.time_ns, newest.time_ns);
      if (dt < camera_span_s) {
        continue;
      }
      if (dt < 2.0 * camera_span_s) {
        const double turned = wrap_angle(newest.yaw - older.yaw);
        const double yaw = older.yaw + 0.5 * turned;
        row[turn_by_camera] = monitor::exactly(turned / dt);
        row[speed_by_camera] = monitor::exactly(
            ((newest.x - older.x) * std::cos(yaw) + (newest.y - older.y) * std::sin(yaw)) / dt);
      }
      break;
    }
  }
  // 4. The accelerations, and what they should be.
  if (alive(Source::accel_x)) {
    row[ahead_felt] = monitor::exactly(signal(Source::accel_x).value);
  }
  if (alive(Source::accel_y)) {
    row[side_felt] = monitor::exactly(signal(Source::accel_y).value);
  }
  if (!std::isnan(v)) {
    if (!std::isnan(gyro)) {
      row[side_by_gyro] = monitor::exactly(v * gyro);
    }
    if (row[turn_by_rear_wheels].known()) {
      row[side_by_rear_wheels] = monitor::exactly(v * row[turn_by_rear_wheels].low);
    }
  }
  history_.append(row);
  // v̇ over a time that resolves the steps of an encoder.
  double wheel_cycle_s = 0.0;
  for (std::size_t i = 0; i < wheel_count; ++i) {
    if (alive(wheel_source(i))) {
      wheel_cycle_s = std::max(wheel_cycle_s, signal(wheel_source(i)).cycle_s);
    }
  }
  const double span_s = std::max(0.16, 2.0 * wheel_cycle_s);
  const auto span = std::min(
      static_cast<std::size_t>(std::ceil(span_s * ns_per_second / look_every_ns)), std::size_t{30});
  const Interval& past = history_.at(span)[speed];
  if (past.known() && !std::isnan(v)) {
    history_.newest()[speed_rate] = monitor::exactly(
        (v - past.low) / (static_cast<double>(span) * look_every_ns * seconds_per_ns));
  }
}

}  // namespace odomd::estimator
