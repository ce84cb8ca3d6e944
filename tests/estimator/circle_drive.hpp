// A drive on a circle for the full filter, sample by sample, each with the time it arrives.
#pragma once

#include <optional>
#include <random>

#include "estimator/common/pose.hpp"
#include "estimator/full_filter.hpp"
#include "tests/estimator/drive.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::testing {

inline constexpr std::int64_t start_ns = 1'000'000'000;

/// Samples of a car on a circle at 2 m/s and 1 rad/s, without noise, each with its time of arrival:
/// wheels 5 ms late, the camera 40 ms.
struct Arrival {
  std::int64_t arrival_ns = 0;
  std::optional<Measurement> signal;
  std::optional<CameraPose> camera;
};

/// The tick of an arrival.
inline std::int64_t tick_of(std::int64_t arrival_ns) {
  return (arrival_ns - start_ns + period_ns - 1) / period_ns;
}

inline constexpr BodyVelocity circle{2.0, 0.0, 1.0};

inline std::vector<Arrival> drive_on_a_circle(std::int64_t duration_ns) {
  std::vector<Arrival> arrivals;
  const auto add = [&](Source source, std::int64_t taken, std::int64_t arrival, double value,
                       double sigma) {
    arrivals.push_back({arrival, Measurement{source, taken, value, sigma, arrival}, {}});
  };
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (std::int64_t t = 0; t < duration_ns; t += period_ns) {
    const std::int64_t now = start_ns + t;
    add(Source::yaw_rate, now, now + millisecond, 1.0 + 0.005 * normal(random), 0.005);
    add(Source::accel_x, now, now + millisecond, 0.0, 0.15);
    add(Source::accel_y, now, now + millisecond, 2.0 + 0.15 * normal(random), 0.15);
    add(Source::steering, now + millisecond, now + 2 * millisecond, 0.15, 0.001);
    if (t % (2 * period_ns) == 0) {
      add(Source::wheel_rear_left, now - 4 * millisecond, now + millisecond, 1.92, 0.007);
      add(Source::wheel_rear_right, now - 4 * millisecond, now + millisecond, 2.08, 0.007);
    }
    if (t % (7 * period_ns) == 0) {
      const Pose2 pose = moved({}, circle, static_cast<double>(t) * 1e-9);
      CameraPose seen{now,
                      now + 40 * millisecond,
                      pose.x + 0.008 * normal(random),
                      pose.y + 0.008 * normal(random),
                      pose.yaw + 0.009 * normal(random),
                      0.008,
                      0.008,
                      0.009};
      arrivals.push_back({seen.arrival_ns, {}, seen});
    }
  }
  std::ranges::stable_sort(arrivals, {}, &Arrival::arrival_ns);
  return arrivals;
}

/// A similar drive with many events: the car stands from 1.4 to 2.2 s, its rear left wheel spins
/// from 2.7 s, single samples of gyro and camera are wrong, and from 3.2 s on the camera sees the
/// car elsewhere.
inline std::vector<Arrival> eventful_drive() {
  std::vector<Arrival> arrivals;
  std::mt19937 random(9);
  std::normal_distribution<double> normal;
  const auto add = [&](Source source, std::int64_t taken, std::int64_t arrival, double value,
                       double sigma) {
    arrivals.push_back({arrival, Measurement{source, taken, value, sigma, arrival}, {}});
  };
  constexpr double per_metre = 0.5;  // [rad/m], of the circle
  const auto speed_at = [](double t) {
    return t < 1.0   ? 2.0
           : t < 1.4 ? 2.0 - 5.0 * (t - 1.0)
           : t < 2.2 ? 0.0
                     : std::min(2.0, 5.0 * (t - 2.2));
  };
  Pose2 pose;
  for (std::int64_t t_ns = 0; t_ns < 4'000 * millisecond; t_ns += period_ns) {
    const double t = static_cast<double>(t_ns) * 1e-9;
    const std::int64_t now = start_ns + t_ns;
    const double v = speed_at(t);
    const double turn = per_metre * v;
    const double noise = v > 0.0 ? 1.0 : 0.1;
    add(Source::yaw_rate, now, now + millisecond,
        turn + 0.005 * noise * normal(random) + (t_ns == 700 * millisecond ? 5.0 : 0.0), 0.005);
    add(Source::accel_x, now, now + millisecond,
        (speed_at(t + 0.01) - v) / 0.01 + 0.15 * noise * normal(random), 0.15);
    add(Source::accel_y, now, now + millisecond, v * turn + 0.15 * noise * normal(random), 0.15);
    add(Source::steering, now + millisecond, now + 2 * millisecond, 0.13, 0.001);
    if (t_ns % (2 * period_ns) == 0) {
      const bool spins = t > 2.7 && t < 3.0;
      const double side = 0.08 * turn;
      const std::int64_t taken = now - 4 * millisecond;
      add(Source::wheel_rear_left, taken, now + millisecond, spins ? 6.0 : v - side, 0.007);
      add(Source::wheel_rear_right, taken, now + millisecond, v + side, 0.007);
      add(Source::wheel_front_left, taken, now + millisecond, v - side, 0.02);
      add(Source::wheel_front_right, taken, now + millisecond, v + side, 0.02);
    }
    if (t_ns % (7 * period_ns) == 0) {
      const bool wrong = t_ns == 140 * period_ns || t > 3.2;
      CameraPose seen{now,
                      now + 40 * millisecond,
                      pose.x + 0.008 * normal(random) + (wrong ? 1.0 : 0.0),
                      pose.y + 0.008 * normal(random) - (wrong ? 2.0 : 0.0),
                      pose.yaw + 0.009 * normal(random),
                      0.008,
                      0.008,
                      0.009};
      arrivals.push_back({seen.arrival_ns, {}, seen});
    }
    pose = moved(pose, {v, 0.0, turn}, 0.005);
  }
  std::ranges::stable_sort(arrivals, {}, &Arrival::arrival_ns);
  return arrivals;
}

/// The samples arrive in any order, each up to 240 ms after it was taken, and all before `end_ns`.
inline std::vector<Arrival> shuffled(std::vector<Arrival> arrivals, std::int64_t end_ns,
                                     std::mt19937& random) {
  for (Arrival& arrival : arrivals) {
    const std::int64_t taken =
        arrival.signal ? arrival.signal->time_ns : arrival.camera->capture_ns;
    const std::int64_t latest = std::min(taken + 240 * millisecond, end_ns);
    if (latest > arrival.arrival_ns) {
      arrival.arrival_ns =
          std::uniform_int_distribution<std::int64_t>{arrival.arrival_ns, latest}(random);
    }
    if (arrival.camera) {
      arrival.camera->arrival_ns = 0;  // otherwise the camera's own limit would apply
    } else {
      arrival.signal->arrival_ns = 0;
    }
  }
  std::ranges::shuffle(arrivals, random);
  std::ranges::stable_sort(arrivals, {}, &Arrival::arrival_ns);
  return arrivals;
}

inline FullFilter started() {
  FullFilter filter({});
  filter.set_initial_pose({});
  return filter;
}

inline void hand_in(FullFilter& filter, const Arrival& arrival) {
  if (arrival.signal) {
    (void)filter.add(*arrival.signal);
  } else {
    (void)filter.add(*arrival.camera);
  }
}

/// Adds every arrival at the first tick at or after it.
inline std::vector<Estimate> run(FullFilter& filter, const std::vector<Arrival>& arrivals,
                                 std::int64_t ticks) {
  std::vector<Estimate> estimates;
  std::size_t next = 0;
  for (std::int64_t k = 1; k <= ticks; ++k) {
    const std::int64_t now = start_ns + k * period_ns;
    for (; next < arrivals.size() && arrivals[next].arrival_ns <= now; ++next) {
      hand_in(filter, arrivals[next]);
    }
    estimates.push_back(filter.step(now));
  }
  return estimates;
}

inline void expect_same_state(const Estimate& a, const Estimate& b) {
  EXPECT_EQ(a.map.x, b.map.x);
  EXPECT_EQ(a.map.y, b.map.y);
  EXPECT_EQ(a.map.yaw, b.map.yaw);
  EXPECT_EQ(a.v_x, b.v_x);
  EXPECT_EQ(a.v_y, b.v_y);
  EXPECT_EQ(a.yaw_rate, b.yaw_rate);
  EXPECT_EQ(a.covariance, b.covariance);
  EXPECT_EQ(a.velocity_covariance, b.velocity_covariance);
  EXPECT_EQ(a.cross_covariance, b.cross_covariance);
  EXPECT_EQ(a.calibration.value, b.calibration.value);
  EXPECT_EQ(a.calibration.sigma, b.calibration.sigma);
  EXPECT_EQ(a.calibration.valid, b.calibration.valid);
  EXPECT_EQ(a.v_x_dot, b.v_x_dot);
  EXPECT_EQ(a.v_y_dot, b.v_y_dot);
  EXPECT_EQ(a.yaw_accel, b.yaw_accel);
  EXPECT_EQ(a.accel_x, b.accel_x);
  EXPECT_EQ(a.accel_y, b.accel_y);
  EXPECT_EQ(a.steering, b.steering);
  EXPECT_EQ(a.reset_count, b.reset_count);
  EXPECT_EQ(a.last_jump.x, b.last_jump.x);
  EXPECT_EQ(a.last_jump.y, b.last_jump.y);
  EXPECT_EQ(a.last_jump.yaw, b.last_jump.yaw);
  EXPECT_EQ(a.camera_test_ratio, b.camera_test_ratio);
  EXPECT_EQ(a.initialised, b.initialised);
  EXPECT_EQ(a.recoveries, b.recoveries);
}

/// Compares the odometry, too, which depends on published velocities and so on the times of
/// arrival.
inline void expect_same_frames(const Estimate& a, const Estimate& b) {
  expect_same_state(a, b);
  EXPECT_EQ(a.odom.x, b.odom.x);
  EXPECT_EQ(a.odom.y, b.odom.y);
  EXPECT_EQ(a.odom.yaw, b.odom.yaw);
  EXPECT_EQ(a.mode, b.mode);
}

}  // namespace odomd::estimator::testing
