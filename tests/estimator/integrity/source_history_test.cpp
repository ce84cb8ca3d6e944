// The history of a source: means and their rates, and repeats. Also camera faults that pass the
// gate at every instant and show only over seconds.
#include "estimator/integrity/source_history.hpp"

#include <functional>

#include "estimator/integrity/camera_consistency.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::integrity::source_history_test {
namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t start_ns = 1'000'000 * ms;

/// A source with a sample every 10 ms for `seconds`.
SourceHistory of(double seconds, const std::function<double(double)>& value) {
  SourceHistory history;
  for (std::int64_t t = 0; t <= static_cast<std::int64_t>(seconds * 1e3); t += 10) {
    const double z = value(static_cast<double>(t) * 1e-3);
    add_sample(history, start_ns + t * ms, z, 0.1, z == history.value);
  }
  return history;
}

TEST(SourceHistory, MeanOfAConstantIsTheConstant) {
  const SourceHistory history = of(1.0, [](double) { return 3.0; });
  for (const Over over : {Over::short_time, Over::long_time}) {
    EXPECT_NEAR(history.mean(over), 3.0, 1e-12);
    EXPECT_NEAR(history.rate(over), 0.0, 1e-9);
  }
  EXPECT_NEAR(history.cycle_s, 0.01, 1e-9);
  EXPECT_NEAR(history.duration_s(), 1.0, 1e-9);
}

TEST(SourceHistory, MeanOfARampLagsAndItsRateIsThatOfTheRamp) {
  const SourceHistory history = of(20.0, [](double t) { return 2.0 * t; });
  for (const Over over : {Over::short_time, Over::long_time}) {
    EXPECT_NEAR(history.mean(over), 2.0 * (20.0 - seconds_of(over)), 0.02);
    EXPECT_NEAR(history.rate(over), 2.0, 0.2);
  }
}

TEST(SourceHistory, BeginsWithTheMedianOfTheFirstFive) {
  SourceHistory history;
  std::int64_t now = start_ns;
  std::vector<double> means;
  for (const double value : {20.0, 20.0, 1.0, 2.0, 1.5}) {
    add_sample(history, now += ms, value, 0.1, false);
    means.push_back(history.mean(Over::long_time));
    EXPECT_EQ(history.alive(now), means.size() >= least_samples);
  }
  EXPECT_EQ(means, (std::vector{20.0, 20.0, 20.0, 20.0, 2.0}));
  add_sample(history, now += ms, 1.7, 0.1, false);
  EXPECT_NEAR(history.mean(Over::long_time), 2.0, 0.1);
}

TEST(SourceHistory, NoiseOfTheMeanIsLessThanThatOfASample) {
  const SourceHistory history = of(3.0, [](double) { return 0.0; });
  EXPECT_NEAR(history.noise(Over::short_time), 0.1 * std::sqrt(0.01 / 0.13), 1e-6);
  EXPECT_NEAR(history.noise(Over::long_time), 0.1 * std::sqrt(0.01 / 1.21), 1e-6);
}

TEST(SourceHistory, RepeatsAfterFourSamplesOfTheSameBitsOverALongEnoughTime) {
  EXPECT_FALSE(of(0.14, [](double) { return 1.0; }).repeats());
  EXPECT_TRUE(of(0.16, [](double) { return 1.0; }).repeats());
  EXPECT_FALSE(of(1.0, [](double t) { return 1.0 + 1e-9 * t; }).repeats());
  // A slow source: the time is long enough, but the samples are too few.
  SourceHistory slow;
  for (int i = 0; i < 3; ++i) add_sample(slow, start_ns + 100 * i * ms, 1.0, 0.1, i > 0);
  EXPECT_FALSE(slow.repeats());
  add_sample(slow, start_ns + 300 * ms, 1.0, 0.1, true);
  EXPECT_TRUE(slow.repeats());
}

TEST(SourceHistory, IsStuckIfItRepeatsMoreOftenThanItsNoiseAllows) {
  const auto noise = [](double t) { return std::sin(900.0 * t); };
  const auto with_noise = [&](double sigma, double step, double until_s) {
    return of(60.0, [&, sigma, step, until_s](double t) {
      const double turn = t < 40.0 ? 0.3 * std::sin(0.4 * t) : 0.0;
      return step * std::round((turn + (t < until_s ? sigma * noise(t) : 0.0)) / step);
    });
  };
  EXPECT_TRUE(with_noise(0.01, 1e-4, 59.5).is_stuck());
  EXPECT_TRUE(with_noise(0.01, 5e-3, 57.0).is_stuck());
  EXPECT_FALSE(with_noise(0.01, 1e-4, 60.1).is_stuck());
  // The quantisation hides the noise: on a long straight the same value repeats.
  EXPECT_FALSE(with_noise(0.0005, 2e-3, 60.1).is_stuck());
  EXPECT_FALSE(with_noise(0.0, 2e-3, 60.1).is_stuck());
}

TEST(SourceHistory, IsAliveForAFewCycles) {
  SourceHistory history;
  EXPECT_FALSE(history.alive(start_ns));
  history = of(1.0, [](double) { return 1.0; });
  EXPECT_TRUE(history.alive(history.time_ns + 40 * ms));
  EXPECT_FALSE(history.alive(history.time_ns + 60 * ms));
}

TEST(SourceHistory, RestartsAfterAGap) {
  SourceHistory history = of(1.0, [](double) { return 1.0; });
  add_sample(history, history.time_ns + 2'000 * ms, 5.0, 0.1, false);
  EXPECT_EQ(history.mean(Over::short_time), 5.0);
  EXPECT_EQ(history.mean(Over::long_time), 5.0);
  EXPECT_EQ(history.duration_s(), 0.0);
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

}  // namespace
}  // namespace odomd::estimator::integrity::source_history_test
