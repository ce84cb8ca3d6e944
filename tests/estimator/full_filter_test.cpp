// The full filter as a whole: what late, shuffled, wrong and missing samples make of it.
#include "estimator/full_filter.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <vector>

#include "estimator/pose.hpp"

namespace odomd::estimator {
namespace {

constexpr std::int64_t millisecond = 1'000'000;
constexpr std::int64_t period_ns = 5 * millisecond;
constexpr std::int64_t start_ns = 1'000'000'000;

/// What a car on a circle of 2 m/s and 1 rad/s measures, without noise, each sample with the time
/// it arrives: wheels 5 ms late, the camera 40 ms.
struct Arrival {
  std::int64_t arrival_ns = 0;
  std::optional<Measurement> signal;
  std::optional<CameraPose> camera;
};

constexpr BodyVelocity circle{2.0, 0.0, 1.0};

std::vector<Arrival> drive_on_a_circle(std::int64_t duration_ns) {
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

FullFilter started() {
  FilterSettings settings;
  FullFilter filter(settings);
  filter.set_initial_pose({});
  return filter;
}

void hand_in(FullFilter& filter, const Arrival& arrival) {
  if (arrival.signal) {
    (void)filter.add(*arrival.signal);
  } else {
    (void)filter.add(*arrival.camera);
  }
}

/// Every arrival is handed in at the first tick that is not before it.
std::vector<Estimate> run(FullFilter& filter, const std::vector<Arrival>& arrivals,
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

void expect_same_state(const Estimate& a, const Estimate& b) {
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
}

TEST(FullFilter, FollowsACircleWithALateCamera) {
  FullFilter filter = started();
  const auto estimates = run(filter, drive_on_a_circle(5'000 * millisecond), 1000);
  const Estimate& last = estimates.back();
  const Pose2 truth = moved({}, circle, static_cast<double>(last.time_ns - start_ns) * 1e-9);
  EXPECT_NEAR(last.map.x, truth.x, 0.01);
  EXPECT_NEAR(last.map.y, truth.y, 0.01);
  EXPECT_NEAR(last.map.yaw, truth.yaw, 0.01);
  EXPECT_NEAR(last.v_x, 2.0, 0.02);
  EXPECT_NEAR(last.yaw_rate, 1.0, 0.02);
  EXPECT_EQ(last.mode, Mode::tracking);
}

TEST(FullFilter, AnyOrderOfArrivalInsideTheWindowGivesTheSameBits) {
  const std::vector<Arrival> in_order = drive_on_a_circle(2'000 * millisecond);
  // In the end everything has arrived: 400 ticks, and what is missing comes 240 ms late at most.
  constexpr std::int64_t ticks = 400;
  FullFilter reference = started();
  const Estimate expected = run(reference, in_order, ticks).back();

  std::mt19937 random(11);
  for (int permutation = 0; permutation < 20; ++permutation) {
    std::vector<Arrival> shuffled = in_order;
    for (Arrival& arrival : shuffled) {
      const std::int64_t taken =
          arrival.signal ? arrival.signal->time_ns : arrival.camera->capture_ns;
      // Not after the last tick, and not before it was taken.
      const std::int64_t latest = std::min(taken + 240 * millisecond, start_ns + ticks * period_ns);
      if (latest > arrival.arrival_ns) {
        arrival.arrival_ns =
            std::uniform_int_distribution<std::int64_t>{arrival.arrival_ns, latest}(random);
      }
    }
    std::ranges::shuffle(shuffled, random);
    std::ranges::stable_sort(shuffled, {}, &Arrival::arrival_ns);
    for (Arrival& arrival : shuffled) {
      if (arrival.camera) {
        arrival.camera->arrival_ns = 0;  // or the camera's own limit would count
      } else {
        arrival.signal->arrival_ns = 0;
      }
    }
    FullFilter filter = started();
    expect_same_state(run(filter, shuffled, ticks).back(), expected);
  }
}

TEST(FullFilter, ASampleThatIsOlderThanTheWindowIsRefused) {
  FullFilter filter = started();
  (void)run(filter, drive_on_a_circle(1'000 * millisecond), 200);
  const std::int64_t now = start_ns + 200 * period_ns;
  EXPECT_EQ(filter.add(Measurement{Source::yaw_rate, now - 251 * millisecond, 0.0, 0.01}),
            Verdict::too_old);
  EXPECT_EQ(filter.add(Measurement{Source::yaw_rate, now - 249 * millisecond, 1.0, 0.01}),
            std::nullopt);
}

}  // namespace
}  // namespace odomd::estimator
