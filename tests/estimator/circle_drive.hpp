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

/// A sample and the time of its arrival.
struct Arrival {
  std::int64_t arrival_ns = 0;
  std::optional<Measurement> signal;
  std::optional<CameraPose> camera;

  [[nodiscard]] std::int64_t taken_ns() const {
    return signal ? signal->time_ns : camera->capture_ns;
  }
};

/// The tick of an arrival.
inline std::int64_t tick_of(std::int64_t arrival_ns) {
  return (arrival_ns - start_ns + period_ns - 1) / period_ns;
}

/// The samples of a drive; the camera's poses have noise and arrive 40 ms late.
struct Recording {
  std::vector<Arrival> arrivals{};
  std::mt19937 random{};
  std::normal_distribution<double> normal{};

  void add(Source source, std::int64_t taken, std::int64_t arrival, double value, double sigma) {
    arrivals.push_back({arrival, Measurement{source, taken, value, sigma, arrival}, {}});
  }
  /// A camera pose with noise; its sigma is `stated` times that noise.
  void see(std::int64_t now, const Pose2& pose, double stated = 1.0) {
    const std::int64_t arrival = now + 40 * millisecond;
    const Pose2 seen{pose.x + 0.008 * normal(random), pose.y + 0.008 * normal(random),
                     pose.yaw + 0.009 * normal(random)};
    arrivals.push_back({arrival,
                        {},
                        CameraPose{now, arrival, seen.x, seen.y, seen.yaw, 0.008 * stated,
                                   0.008 * stated, 0.009 * stated}});
  }
  std::vector<Arrival> in_order() {
    std::ranges::stable_sort(arrivals, {}, &Arrival::arrival_ns);
    return arrivals;
  }
};

inline constexpr BodyVelocity circle{2.0, 0.0, 1.0};

/// The pose of a car on the circle at a time.
inline Pose2 on_circle(std::int64_t time_ns) {
  return moved({}, circle, static_cast<double>(time_ns - start_ns) * 1e-9);
}

/// Samples of a car on a circle at 2 m/s and 1 rad/s: wheels 5 ms late, the camera 40 ms.
inline std::vector<Arrival> drive_on_a_circle(std::int64_t duration_ns) {
  Recording drive{.random = std::mt19937(7)};
  auto& [arrivals, random, normal] = drive;
  for (std::int64_t t = 0; t < duration_ns; t += period_ns) {
    const std::int64_t now = start_ns + t;
    drive.add(Source::yaw_rate, now, now + millisecond, 1.0 + 0.005 * normal(random), 0.005);
    drive.add(Source::accel_x, now, now + millisecond, 0.0, 0.15);
    drive.add(Source::accel_y, now, now + millisecond, 2.0 + 0.15 * normal(random), 0.15);
    drive.add(Source::steering, now + millisecond, now + 2 * millisecond, 0.15, 0.001);
    if (t % (2 * period_ns) == 0) {
      const std::int64_t taken = now - 4 * millisecond;
      drive.add(Source::wheel_rear_left, taken, now + millisecond, 1.92, 0.007);
      drive.add(Source::wheel_rear_right, taken, now + millisecond, 2.08, 0.007);
    }
    if (t % (7 * period_ns) == 0) drive.see(now, on_circle(now));
  }
  return drive.in_order();
}

/// A similar drive with many events: the car stands from 1.4 to 2.2 s, its rear left wheel spins
/// from 2.7 s, single samples of gyro and camera are wrong, and from 3.2 s on the camera sees the
/// car elsewhere.
inline std::vector<Arrival> eventful_drive() {
  Recording drive{.random = std::mt19937(9)};
  auto& [arrivals, random, normal] = drive;
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
    drive.add(Source::yaw_rate, now, now + millisecond,
              turn + 0.005 * noise * normal(random) + (t_ns == 700 * millisecond ? 5.0 : 0.0),
              0.005);
    drive.add(Source::accel_x, now, now + millisecond,
              (speed_at(t + 0.01) - v) / 0.01 + 0.15 * noise * normal(random), 0.15);
    drive.add(Source::accel_y, now, now + millisecond, v * turn + 0.15 * noise * normal(random),
              0.15);
    drive.add(Source::steering, now + millisecond, now + 2 * millisecond, 0.13, 0.001);
    if (t_ns % (2 * period_ns) == 0) {
      const bool spins = t > 2.7 && t < 3.0;
      const double side = 0.08 * turn;
      const std::int64_t taken = now - 4 * millisecond;
      drive.add(Source::wheel_rear_left, taken, now + millisecond, spins ? 6.0 : v - side, 0.007);
      drive.add(Source::wheel_rear_right, taken, now + millisecond, v + side, 0.007);
      drive.add(Source::wheel_front_left, taken, now + millisecond, v - side, 0.02);
      drive.add(Source::wheel_front_right, taken, now + millisecond, v + side, 0.02);
    }
    if (t_ns % (7 * period_ns) == 0) {
      const bool wrong = t_ns == 140 * period_ns || t > 3.2;
      drive.see(now, wrong ? Pose2{pose.x + 1.0, pose.y - 2.0, pose.yaw} : pose);
    }
    pose = moved(pose, {v, 0.0, turn}, 0.005);
  }
  return drive.in_order();
}

/// The samples arrive in any order, each up to 240 ms after it was taken, and all before `end_ns`.
inline std::vector<Arrival> shuffled(std::vector<Arrival> arrivals, std::int64_t end_ns,
                                     std::mt19937& random) {
  for (Arrival& arrival : arrivals) {
    const std::int64_t latest = std::min(arrival.taken_ns() + 240 * millisecond, end_ns);
    if (latest > arrival.arrival_ns) {
      arrival.arrival_ns =
          std::uniform_int_distribution<std::int64_t>{arrival.arrival_ns, latest}(random);
    }
    // With a time of arrival, the camera's own limit would apply.
    (arrival.camera ? arrival.camera->arrival_ns : arrival.signal->arrival_ns) = 0;
  }
  std::ranges::shuffle(arrivals, random);
  std::ranges::stable_sort(arrivals, {}, &Arrival::arrival_ns);
  return arrivals;
}

inline FullFilter started(const FilterSettings& settings = {}) {
  FullFilter filter(settings);
  filter.set_initial_pose({});
  return filter;
}

/// Adds what arrives after the tick `before`, up to `tick`, and steps to `tick`.
inline Estimate step_to(FullFilter& filter, const std::vector<Arrival>& arrivals,
                        std::int64_t before, std::int64_t tick) {
  const auto by_tick = [](const Arrival& arrival) { return tick_of(arrival.arrival_ns); };
  const auto end = std::ranges::upper_bound(arrivals, tick, {}, by_tick);
  for (auto it = std::ranges::upper_bound(arrivals, before, {}, by_tick); it != end; ++it)
    (void)(it->signal ? filter.add(*it->signal) : filter.add(*it->camera));
  return filter.step(start_ns + tick * period_ns);
}

/// Steps through the ticks from `first` to `last`; before each, adds what has arrived by then.
inline std::vector<Estimate> run(FullFilter& filter, const std::vector<Arrival>& arrivals,
                                 std::int64_t last, std::int64_t first = 1) {
  std::vector<Estimate> estimates;
  for (std::int64_t k = first; k <= last; ++k)
    estimates.push_back(step_to(filter, arrivals, k - 1, k));
  return estimates;
}
/// The same for a new filter.
inline std::vector<Estimate> run(const std::vector<Arrival>& arrivals, std::int64_t last) {
  FullFilter filter = started();
  return run(filter, arrivals, last);
}

}  // namespace odomd::estimator::testing
