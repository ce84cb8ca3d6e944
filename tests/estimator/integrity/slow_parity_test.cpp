// Parities over seconds: faults inside every instant's gate.
#include "estimator/integrity/slow_parity.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "estimator/integrity/integrity.hpp"

namespace odomd::estimator::integrity::slow_parity_test {
namespace {

constexpr std::int64_t ms = 1'000'000;

/// A slalom at 1.5 m/s, with a gyro that reads `gyro(ψ̇)`.
template <class Gyro>
SlowParities slalom(double seconds, const Gyro& gyro) {
  const Vehicle car;
  Observations observed;
  SlowParities slow;
  const auto add = [&](Source source, double value) {
    add_sample(observed.sources[index_of(source)], observed.now_ns, value, 0.01, false, 1e9);
  };
  for (int i = 1; i < static_cast<int>(100.0 * seconds); ++i) {
    observed.now_ns = 10 * ms * i;
    const double turn = 1.2 * std::sin(0.013 * i);
    constexpr double v = 1.5;
    observed.speeds.fill(v);
    observed.yaw_rates.fill(turn);
    add(Source::yaw_rate, gyro(turn));
    add(Source::accel_y, 1.02 * v * turn + 0.1 * std::sin(0.9 * i));
    add(Source::wheel_rear_left, v - 0.5 * car.track_width * turn);
    add(Source::wheel_rear_right, v + 0.5 * car.track_width * turn);
    if (i % 2 == 0) slow.add({}, observed, false, 0.02);
  }
  return slow;
}

TEST(SlowParities, AgreeWithAGoodGyro) {
  const SlowParities slow = slalom(60.0, [](double turn) { return 1.02 * turn + 0.01; });
  EXPECT_FALSE(slow.contradicted());
}

TEST(SlowParities, IsolateAGyroThatReadsLow) {
  const SlowParities slow = slalom(30.0, [](double turn) { return 0.7 * turn; });
  EXPECT_TRUE(slow.contradicted());
  EXPECT_EQ(slow.faulty(), only(Source::yaw_rate));
}

TEST(SlowParities, IsolateAGyroThatReadsLowToOneSide) {
  const SlowParities slow =
      slalom(30.0, [](double turn) { return turn < 0.0 ? 0.65 * turn : turn; });
  EXPECT_EQ(slow.faulty(), only(Source::yaw_rate));
}

TEST(SlowParities, DoNotJudgeFromASingleTurn) {
  EXPECT_FALSE(slalom(3.0, [](double turn) { return 0.5 * turn; }).contradicted());
}

TEST(CameraConsistency, DetectsAnErrorThatStays) {
  CameraConsistency good;
  CameraConsistency bad;
  for (int i = 0; i < 300; ++i) {
    const double noise = 1.5 * std::sin(2.3 * i);
    good.add({noise, -noise, noise}, {1.0, 1.0, 1.0});
    EXPECT_FALSE(good.contradicted());
    bad.add({0.2 * noise + 0.48, 0.0, 0.0}, {0.04, 1.0, 1.0});
  }
  EXPECT_TRUE(bad.contradicted());
}

TEST(CameraConsistency, ForgivesAnOutlier) {
  CameraConsistency camera;
  camera.add({50.0, -50.0, 3.0}, {1.0, 1.0, 1.0});
  EXPECT_FALSE(camera.contradicted());
}

bool drifts(double rate) {
  CameraClock clock;
  bool drifted = false;
  for (int i = 1; i < 1000; ++i) {
    const std::int64_t arrival_ns = 33 * ms * i;
    const double latency_s = 0.03 + 0.008 * std::sin(7.0 * i) + rate * 0.033 * i;
    clock.add(arrival_ns - static_cast<std::int64_t>(latency_s * 1e9), arrival_ns);
    drifted = drifted || clock.drifts();
  }
  return drifted;
}

TEST(CameraClock, DetectsAnotherRate) {
  EXPECT_TRUE(drifts(0.005));
  EXPECT_TRUE(drifts(-0.005));
  EXPECT_FALSE(drifts(0.0));
  EXPECT_FALSE(drifts(1e-4));
}

TEST(SourceHistory, ANoisySourceThatRepeatsIsStuck) {
  SourceHistory noisy;
  SourceHistory quantised;
  for (int i = 1; i < 4000; ++i) {
    const bool frozen = i > 3970;
    add_sample(noisy, 10 * ms * i, frozen ? 0.0 : std::sin(9.0 * i), 0.01, frozen && i > 3971, 1e9);
    add_sample(quantised, 10 * ms * i, 0.0, 0.01, i % 50 != 0, 1e9);
    EXPECT_FALSE(quantised.is_stuck());
    EXPECT_TRUE(frozen || !noisy.is_stuck());
  }
  EXPECT_TRUE(noisy.is_stuck());
}

}  // namespace
}  // namespace odomd::estimator::integrity::slow_parity_test
