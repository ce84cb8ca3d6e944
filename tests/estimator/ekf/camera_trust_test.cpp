// A camera that contradicts the car's own sensors: which of them the filter follows, and what it
// learns.
#include <functional>
#include <numbers>
#include <optional>
#include <random>

#include "estimator/full_filter.hpp"
#include "tests/estimator/circle_drive.hpp"

namespace odomd::estimator::testing::camera_trust_test {
namespace {

constexpr std::int64_t ticks = 2000;
constexpr std::int64_t fault_ns = start_ns + 4'000 * millisecond;

double off(const Estimate& e) {
  const Pose2 truth = on_circle(e.time_ns);
  return std::hypot(e.map.x - truth.x, e.map.y - truth.y);
}

/// Ten seconds on a circle at 2 m/s; `change` is called with every arrival from the fourth on.
std::vector<Estimate> drive_with(const std::function<void(Arrival&)>& change) {
  std::vector<Arrival> arrivals = drive_on_a_circle(ticks * period_ns);
  for (Arrival& arrival : arrivals)
    if (arrival.arrival_ns >= fault_ns) change(arrival);
  return run(arrivals, ticks);
}

TEST(CameraTrust, AFrozenPictureDoesNotDragTheCarAlong) {
  for (const double noise : {0.0, 0.008}) {
    std::mt19937 random(3);
    std::normal_distribution<double> trembling;
    std::optional<CameraPose> frozen;
    const auto freeze = [&](Arrival& arrival) {
      if (!arrival.camera || arrival.arrival_ns > fault_ns + 3'000 * millisecond) return;
      if (!frozen) frozen = arrival.camera;
      for (double CameraPose::*const number : {&CameraPose::x, &CameraPose::y, &CameraPose::yaw})
        (*arrival.camera).*number = (*frozen).*number + noise * trembling(random);
    };
    for (const Estimate& e : drive_with(freeze)) {
      ASSERT_LT(off(e), 0.05) << e.time_ns - start_ns << " ns, noise " << noise;
      ASSERT_EQ(e.reset_count, 1U);
    }
  }
}

TEST(CameraTrust, APictureOfAStandingCarIsNotFrozen) {
  // Noise-free poses of a car that was put down elsewhere.
  Drive car = start(Model::full);
  for (int k = 1; k <= 800; ++k) {
    for (const Source source : {Source::yaw_rate, Source::accel_x, Source::accel_y,
                                Source::wheel_rear_left, Source::wheel_rear_right})
      car.send(source, 0.0, 0.01, millisecond);
    if (k % 7 == 0) car.see({k > 300 ? 1.0 : 0.0, 0.0, 0.0}, 0.008, 0.009, 40 * millisecond);
    car.tick();
  }
  EXPECT_NEAR(car.last.map.x, 1.0, 0.01);
  EXPECT_EQ(car.last.mode, Mode::standstill);
}

TEST(CameraTrust, AStepOfTheGyroBiasIsLearntOnTheMove) {
  for (const double step : {0.02, 0.05, -0.2}) {
    const std::vector<Estimate> estimates = drive_with([step](Arrival& arrival) {
      if (arrival.signal && arrival.signal->source == Source::yaw_rate)
        arrival.signal->value += step;
    });
    const Estimate& last = estimates.back();
    EXPECT_LT(last.reset_count, 6U) << step;
    // At a constant yaw rate, bias and scale cannot be separated.
    EXPECT_NEAR(last.calibration.value[0] + (last.calibration.value[1] - 1.0) * circle.yaw_rate,
                step, 0.01)
        << step;
    EXPECT_NEAR(last.yaw_rate, circle.yaw_rate, 0.03) << step;
    EXPECT_LT(off(last), 0.02);
  }
}

TEST(CameraTrust, AFlippedHeadingDoesNotTurnTheCar) {
  // Half a turn off, plus noise: the shorter way round changes from pose to pose.
  const auto flip = [](Arrival& arrival) {
    if (arrival.camera && arrival.arrival_ns < fault_ns + 2'000 * millisecond)
      arrival.camera->yaw += std::numbers::pi;
  };
  const std::vector<Estimate> estimates = drive_with(flip);
  for (const Estimate& e : estimates) {
    ASSERT_LT(std::abs(e.yaw_rate), 5.0) << e.time_ns - start_ns;
    ASSERT_TRUE(e.time_ns < fault_ns || off(e) < 0.05) << e.time_ns - start_ns << ": " << off(e);
  }
  EXPECT_LT(off(estimates.back()), 0.02);
  EXPECT_NEAR(estimates.back().yaw_rate, circle.yaw_rate, 0.03);
}

TEST(CameraTrust, WheelsThatSlipLeaveNoError) {
  // All wheels slip for three seconds, by a little or a lot.
  for (const double slip : {0.8, 1.2, 1.5, 3.0}) {
    const auto slipping = [slip](Arrival& arrival) {
      if (arrival.signal && is_wheel(arrival.signal->source) &&
          arrival.arrival_ns < fault_ns + 3'000 * millisecond)
        arrival.signal->value *= slip;
    };
    const std::vector<Estimate> estimates = drive_with(slipping);
    for (const Estimate& e : estimates) {
      ASSERT_LT(off(e), 0.3) << slip << ' ' << e.time_ns - start_ns;
      ASSERT_TRUE(off(e) < 0.2 || e.doubtful) << slip << ' ' << e.time_ns - start_ns;
    }
    EXPECT_LE(estimates.back().reset_count, 20U) << slip;
    EXPECT_LT(off(estimates.back()), 0.02) << slip;
  }
}

TEST(CameraTrust, ACarThatIsSeenDrivingDoesNotStand) {
  // A departure from a standstill, with dead wheels.
  Drive car = start(Model::full);
  int badly = 0;
  std::mt19937 random(4);
  std::normal_distribution<double> noise(0.0, 0.01);
  const auto x_at = [](double t) {  // sets off at 1 m/s², to 1 m/s
    return t < 2.0 ? 0.0 : t < 3.0 ? 0.5 * (t - 2.0) * (t - 2.0) : t - 2.5;
  };
  for (int k = 1; k <= 1200; ++k) {
    const double t = k * 0.005;
    for (const Source source : {Source::yaw_rate, Source::accel_x, Source::accel_y}) {
      const double pull = source == Source::accel_x && t > 2.0 && t < 3.0 ? 1.0 : 0.0;
      car.send(source, pull + noise(random), 0.01, millisecond);
    }
    for (const Source source : {Source::wheel_rear_left, Source::wheel_rear_right})
      car.send(source, 0.0, 0.01, millisecond);
    if (k % 7 == 0) car.see({x_at(t - 0.04), 0.0, 0.0}, 0.008, 0.009, 40 * millisecond);
    badly += std::abs(car.tick().map.x - x_at(t)) > 0.3 ? 1 : 0;
  }
  EXPECT_LT(badly, 160);
  EXPECT_LT(car.last.reset_count, 8U);
}

TEST(CameraTrust, ANoisyCameraIsTrustedWhileTheCarStands) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, 1.0);
  Drive car = start(Model::full);
  for (int k = 1; k <= 12'000; ++k) {  // a minute
    for (const Source source : {Source::yaw_rate, Source::wheel_rear_left})
      car.send(source, 0.0, 0.01, millisecond);
    if (k % 7 == 0) {
      const Pose2 pose{0.08 * noise(random), 0.08 * noise(random), 0.009 * noise(random)};
      car.see(pose, 0.08, 0.009, 40 * millisecond);
    }
    car.tick();
    ASSERT_EQ(flag(car.filter, Source::camera), SourceFlag::ok) << k;
  }
}

}  // namespace
}  // namespace odomd::estimator::testing::camera_trust_test
