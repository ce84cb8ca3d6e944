// What the sources have said lately, and which of it contradicts which.
#include "estimator/integrity/monitor/testimony.hpp"

#include <algorithm>

#include "estimator/integrity/source_monitor.hpp"

namespace odomd::estimator {

using monitor::Contradicted;
using monitor::gap;
using monitor::Interval;
using monitor::Testimony;
using monitor::wheel_count;
using monitor::wheel_source;
using enum monitor::Turning;

Testimony SourceMonitor::testimony(const Spans& spans) const noexcept {
  // The camera's motion is a mean over some time before now.
  constexpr std::size_t camera_rows = 2;
  const auto over = [this](std::size_t column, std::size_t rows) {
    return history_.over(column, rows);
  };
  Testimony told;
  for (std::size_t i = 0; i < wheel_count; ++i) {
    told.speeds[i] = over(first_wheel + i, spans.wheels);
  }
  told.speeds[monitor::seen_speed] = over(speed_by_camera, camera_rows);
  told.speed = over(speed, spans.all);
  for (const auto& [turning, column] : {std::pair{by_gyro, turn_by_gyro},
                                        {by_steering, turn_by_steering},
                                        {by_rear_axle, turn_by_rear_wheels},
                                        {by_front_axle, turn_by_front_wheels}}) {
    told.turns[turning] = over(column, spans.all);
    told.turns_longer[turning] = over(column, spans.beside_camera);
  }
  told.turns[by_camera] = over(turn_by_camera, camera_rows);
  for (const auto& [turning, column] : {std::pair{by_gyro, side_by_gyro},
                                        {by_steering, side_by_steering},
                                        {by_rear_axle, side_by_rear_wheels},
                                        {by_felt, side_felt}}) {
    told.sides[turning] = over(column, spans.all);
  }
  told.ahead_felt = over(ahead_felt, spans.all);
  told.ahead_felt_shortly = over(ahead_felt, spans.wheels);
  told.speed_rate = over(speed_rate, spans.all);
  return told;
}

Contradicted SourceMonitor::contradicted(const Testimony& told) const noexcept {
  const auto sigma = [this](Source source) { return sigma_[index_of(source)]; };
  Contradicted found;

  // 1. v_x.
  const auto speed_noise = [&](std::size_t i) {
    return i == monitor::seen_speed ? 5.0 * 1.4 * newest_pose().sigma / monitor::camera_span_s
                                    : 3.0 * sigma(wheel_source(i));
  };
  for (std::size_t i = 0; i < monitor::speed_count; ++i) {
    for (std::size_t j = i + 1; j < monitor::speed_count; ++j) {
      const Interval& a = told.speeds[i];
      const Interval& b = told.speeds[j];
      const double fastest = std::max(a.largest(), b.largest());
      if (gap(a, b) > 0.12 + 0.12 * fastest + speed_noise(i) + speed_noise(j)) {
        found.speeds.add(i, j);
      }
    }
  }

  // 2. v̇_x.
  found.lengthwise = gap(told.ahead_felt, told.speed_rate) > lengthwise_error(told);

  // 3. ψ̇ and v ψ̇, of a car that moves.
  const double fastest = told.speed.largest();
  if (!(fastest >= monitor::slowest_speed)) {
    return found;
  }
  const auto of_axle = [&](Source left, Source right) {
    return (2.0 * std::max(sigma(left), sigma(right)) + 0.012 * fastest) / car_.track_width;
  };
  std::array<double, monitor::turning_count> error{};
  error[by_gyro] = 0.05 + 2.0 * sigma(Source::yaw_rate);
  error[by_steering] =
      0.03 + std::max(3.0 * sigma(Source::steering), 0.01) * fastest / car_.wheelbase();
  error[by_rear_axle] = of_axle(Source::wheel_rear_left, Source::wheel_rear_right);
  error[by_front_axle] = of_axle(Source::wheel_front_left, Source::wheel_front_right);
  error[by_camera] = 0.05 + 5.0 * 1.4 * newest_pose().sigma_yaw / monitor::camera_span_s;
  error[by_felt] = 1.2 + sigma(Source::accel_y);

  const auto check = [&](std::size_t i, const Interval& a, std::size_t j, const Interval& b,
                         double errors) {
    constexpr double share = 0.12;
    if (gap(a, b) > errors + share * std::max(a.largest(), b.largest())) {
      found.turns.add(i, j);
    }
  };
  constexpr std::array own{by_gyro, by_steering, by_rear_axle, by_front_axle};
  for (std::size_t i = 0; i < own.size(); ++i) {
    for (std::size_t j = i + 1; j < own.size(); ++j) {
      check(own[i], told.turns[own[i]], own[j], told.turns[own[j]], error[own[i]] + error[own[j]]);
    }
  }
  for (const auto turning : {by_gyro, by_steering, by_rear_axle}) {
    check(turning, told.turns_longer[turning], by_camera, told.turns[by_camera],
          error[turning] + error[by_camera]);
    check(turning, told.sides[turning], by_felt, told.sides[by_felt],
          error[by_felt] + fastest * error[turning]);
  }
  return found;
}

double SourceMonitor::lengthwise_error(const Testimony& told) const noexcept {
  return 1.5 + sigma_[index_of(Source::accel_x)] +
         0.2 * std::max(told.ahead_felt.largest(), told.speed_rate.largest());
}

}  // namespace odomd::estimator
