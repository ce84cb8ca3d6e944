// One verdict for each sample, and the newest value held.
#include "estimator/baselines/held_signals.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace odomd::estimator::held_signals_test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::int64_t latest = 1'000;

Verdict take(HeldSignals& held, std::int64_t time_ns, double value, double sigma = 0.1) {
  return held.take({Source::wheel_rear, time_ns, value, sigma}, latest);
}

TEST(HeldSignals, HoldsNothingAtFirst) {
  const HeldSignals held{{}};
  EXPECT_FALSE(held.seen(Source::wheel_rear));
  EXPECT_EQ(held.value(Source::wheel_rear), 0.0);
}

TEST(HeldSignals, HoldsTheNewestByItsOwnTimeInAnyOrder) {
  HeldSignals held{{}};
  EXPECT_EQ(take(held, 200, 2.0), Verdict::fused);
  EXPECT_EQ(take(held, 100, 1.0), Verdict::too_old);
  EXPECT_EQ(held.value(Source::wheel_rear), 2.0);
  EXPECT_EQ(take(held, 300, 3.0), Verdict::fused);
  EXPECT_EQ(held.value(Source::wheel_rear), 3.0);
  EXPECT_EQ(held.time_ns(Source::wheel_rear), 300);
}

TEST(HeldSignals, SameSourceAndTimeIsADuplicate) {
  HeldSignals held{{}};
  EXPECT_EQ(take(held, 200, 2.0), Verdict::fused);
  EXPECT_EQ(take(held, 200, 2.5), Verdict::duplicate);
  EXPECT_EQ(held.value(Source::wheel_rear), 2.0);
  EXPECT_EQ(held.take({Source::motor, 200, 1.0, 0.1}, latest), Verdict::fused);
}

TEST(HeldSignals, NonFiniteNumbersChangeNothing) {
  HeldSignals held{{}};
  for (const double value : {nan, infinity, -infinity}) {
    EXPECT_EQ(take(held, 100, value), Verdict::non_finite);
  }
  for (const double sigma : {nan, infinity, -0.1}) {
    EXPECT_EQ(take(held, 100, 1.0, sigma), Verdict::non_finite);
  }
  EXPECT_FALSE(held.seen(Source::wheel_rear));
}

TEST(HeldSignals, SampleAheadOfTheLimitIsFromTheFuture) {
  HeldSignals held{{}};
  EXPECT_EQ(take(held, latest, 1.0), Verdict::fused);
  EXPECT_EQ(take(held, latest + 1, 2.0), Verdict::future);
  EXPECT_EQ(take(held, std::numeric_limits<std::int64_t>::max(), 2.0), Verdict::future);
  EXPECT_EQ(held.value(Source::wheel_rear), 1.0);
}

TEST(HeldSignals, WhatNoCarDoesIsGated) {
  HeldSignals held{{}};
  EXPECT_EQ(take(held, 100, 151.0), Verdict::gated);
  EXPECT_EQ(take(held, 100, -1e300), Verdict::gated);
  EXPECT_EQ(held.take({Source::steering, 100, 1.5707, 0.1}, latest), Verdict::gated);
  EXPECT_EQ(held.take({Source::direction, 100, -2.0, 0.1}, latest), Verdict::gated);
  EXPECT_EQ(take(held, 100, -149.0), Verdict::fused);
}

TEST(HeldSignals, CameraAndUnknownSourcesAreNoSignals) {
  HeldSignals held{{}};
  EXPECT_EQ(held.take({Source::camera, 100, 0.0, 0.1}, latest), Verdict::source_off);
  EXPECT_EQ(held.take({Source::count, 100, 0.0, 0.1}, latest), Verdict::source_off);
  EXPECT_EQ(held.take({static_cast<Source>(200), 100, 0.0, 0.1}, latest), Verdict::source_off);
}

TEST(HeldSignals, SigmaIsTheSamplesOwnElseTheSettingsElseTheDefault) {
  std::array<double, source_count> settings{};
  settings[static_cast<std::size_t>(Source::motor)] = 0.7;
  HeldSignals held{settings};
  EXPECT_EQ(held.take({Source::motor, 100, 1.0, 0.0}, latest), Verdict::fused);
  EXPECT_EQ(held.sigma(Source::motor), 0.7);
  EXPECT_EQ(held.take({Source::motor, 200, 1.0, 0.2}, latest), Verdict::fused);
  EXPECT_EQ(held.sigma(Source::motor), 0.2);
  EXPECT_EQ(held.sigma(Source::steering),
            default_sigma[static_cast<std::size_t>(Source::steering)]);
}

}  // namespace
}  // namespace odomd::estimator::held_signals_test
