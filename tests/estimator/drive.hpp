// Passes simulated samples to a filter, tick by tick; compares poses and estimates.
#pragma once

#include <optional>
#include <tuple>

#include "estimator/filter.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::testing {

inline constexpr std::int64_t millisecond = 1'000'000;
inline constexpr std::int64_t period_ns = 5 * millisecond;

/// Matches a pose within `way` in x and y and `turn` in its yaw.
inline ::testing::Matcher<const Pose2&> PoseNear(const Pose2& pose, double way, double turn) {
  using ::testing::DoubleNear;
  return ::testing::FieldsAre(DoubleNear(pose.x, way), DoubleNear(pose.y, way),
                              DoubleNear(pose.yaw, turn));
}
inline ::testing::Matcher<const Pose2&> PoseNear(const Pose2& pose, double tolerance) {
  return PoseNear(pose, tolerance, tolerance);
}

inline std::array<double, 3> numbers_of(const Pose2& pose) {
  return {pose.x, pose.y, pose.yaw};
}

/// The part of an estimate that depends on the samples alone, not on their times of arrival.
inline auto state_of(const Estimate& e) {
  const std::array motion{e.v_x,       e.v_y,     e.yaw_rate, e.v_x_dot,  e.v_y_dot,
                          e.yaw_accel, e.accel_x, e.accel_y,  e.steering, e.camera_test_ratio};
  return std::tuple(numbers_of(e.map), motion, e.covariance, e.velocity_covariance,
                    e.cross_covariance, e.calibration.value, e.calibration.sigma,
                    e.calibration.valid, e.reset_count, numbers_of(e.last_jump), e.initialised,
                    e.recoveries);
}

inline void expect_same_state(const Estimate& a, const Estimate& b) {
  EXPECT_EQ(state_of(a), state_of(b));
}

/// Also compares the odometry, which depends on the published velocities and thus on the times of
/// arrival.
inline void expect_same_frames(const Estimate& a, const Estimate& b) {
  expect_same_state(a, b);
  EXPECT_EQ(numbers_of(a.odom), numbers_of(b.odom));
  EXPECT_EQ(a.mode, b.mode);
}

/// The samples of one tick; missing ones are not sent.
struct Samples {
  std::optional<double> speed = std::nullopt;  ///< wheel_rear
  std::optional<double> steering = std::nullopt;
  std::optional<double> yaw_rate = std::nullopt;
  std::optional<double> accel_x = std::nullopt;
};

/// A filter and the clock of its ticks.
struct Drive {
  Filter filter;
  std::int64_t now_ns = 1'000'000'000;
  Estimate last{};

  /// Sends a sample that arrives with the next tick.
  std::optional<Verdict> send(Source source, double value, double sigma = 0.0,
                              std::int64_t age_ns = 0) {
    const std::int64_t arrival_ns = now_ns + period_ns;
    return add(filter, Measurement{source, arrival_ns - age_ns, value, sigma, arrival_ns});
  }
  std::optional<Verdict> see(const Pose2& pose, double sigma, double sigma_yaw,
                             std::int64_t age_ns = 0) {
    const std::int64_t arrival_ns = now_ns + period_ns;
    return add(filter, CameraPose{arrival_ns - age_ns, arrival_ns, pose.x, pose.y, pose.yaw, sigma,
                                  sigma, sigma_yaw});
  }

  /// Drives one tick; the samples have its time.
  Estimate tick(const Samples& samples = {}) {
    if (samples.speed) send(Source::wheel_rear, *samples.speed);
    if (samples.steering) send(Source::steering, *samples.steering);
    if (samples.yaw_rate) send(Source::yaw_rate, *samples.yaw_rate);
    if (samples.accel_x) send(Source::accel_x, *samples.accel_x);
    now_ns += period_ns;
    last = step(filter, now_ns);
    return last;
  }

  Estimate ticks(int count, const Samples& samples) {
    for (int i = 0; i < count; ++i) tick(samples);
    return last;
  }
};

inline Drive start(Model model, FilterSettings settings = {},
                   std::optional<Pose2> initial = Pose2{}) {
  Drive drive{make_filter(model, settings)};
  if (initial) set_initial_pose(drive.filter, *initial);
  return drive;
}

}  // namespace odomd::estimator::testing
