// What is kept of a source's samples: means, how fast they change, repeats and jumps.
#include "estimator/integrity/witness.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace odomd::estimator::integrity::witness_test {
namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t start_ns = 1'000'000 * ms;

/// A source that is heard each 10 ms, for so long.
Witness of(double seconds, const std::function<double(double)>& value) {
  Witness witness;
  for (std::int64_t t = 0; t <= static_cast<std::int64_t>(seconds * 1e3); t += 10) {
    const double z = value(static_cast<double>(t) * 1e-3);
    hear(witness, start_ns + t * ms, z, 0.1, z == witness.value, 0.5);
  }
  return witness;
}

TEST(Witness, MeanOfWhatDoesNotChangeIsThat) {
  const Witness witness = of(1.0, [](double) { return 3.0; });
  for (const Over over : {Over::short_time, Over::long_time}) {
    EXPECT_NEAR(witness.mean(over), 3.0, 1e-12);
    EXPECT_NEAR(witness.rate(over), 0.0, 1e-9);
  }
  EXPECT_NEAR(witness.cycle_s, 0.01, 1e-9);
  EXPECT_NEAR(witness.heard_s(), 1.0, 1e-9);
}

TEST(Witness, MeanIsOfLatelyAndTheRateThatOfTheMean) {
  const Witness witness = of(20.0, [](double t) { return 2.0 * t; });
  for (const Over over : {Over::short_time, Over::long_time}) {
    EXPECT_NEAR(witness.mean(over), 2.0 * (20.0 - seconds_of(over)), 0.02);
    EXPECT_NEAR(witness.rate(over), 2.0, 0.2);
  }
}

TEST(Witness, MeanOfTheFirstFewIsThatOfAll) {
  Witness witness;
  for (const double value : {1.0, 2.0, 3.0, 4.0}) {
    hear(witness, start_ns + static_cast<std::int64_t>(value) * ms, value, 0.1, false, 1e9);
  }
  // Each but the last is the middle one of three.
  EXPECT_NEAR(witness.mean(Over::long_time), 1.75, 0.01);
}

TEST(Witness, NoiseOfTheMeanIsLessThanThatOfASample) {
  const Witness witness = of(3.0, [](double) { return 0.0; });
  EXPECT_NEAR(witness.noise(Over::short_time), 0.1 * std::sqrt(0.01 / 0.13), 1e-6);
  EXPECT_NEAR(witness.noise(Over::long_time), 0.1 * std::sqrt(0.01 / 1.21), 1e-6);
}

TEST(Witness, RepeatsAfterFourSamplesOfTheSameBitsOverALongEnoughTime) {
  EXPECT_FALSE(of(0.14, [](double) { return 1.0; }).repeats());
  EXPECT_TRUE(of(0.16, [](double) { return 1.0; }).repeats());
  EXPECT_FALSE(of(1.0, [](double t) { return 1.0 + 1e-9 * t; }).repeats());
  // A slow one: over a long enough time, but too few.
  Witness slow;
  for (int i = 0; i < 3; ++i) hear(slow, start_ns + 100 * i * ms, 1.0, 0.1, i > 0, 0.5);
  EXPECT_FALSE(slow.repeats());
  hear(slow, start_ns + 300 * ms, 1.0, 0.1, true, 0.5);
  EXPECT_TRUE(slow.repeats());
}

TEST(Witness, NotesAJumpAndWhen) {
  const Witness calm = of(1.0, [](double t) { return t < 0.5 ? 1.0 : 1.4; });
  EXPECT_EQ(calm.jumped_ns, 0);
  const Witness jumped = of(1.0, [](double t) { return t < 0.5 ? 1.0 : 1.6; });
  EXPECT_EQ(jumped.jumped_ns, start_ns + 500 * ms);
}

TEST(Witness, IsAliveForAFewOfItsCycles) {
  Witness witness;
  EXPECT_FALSE(witness.alive(start_ns));
  witness = of(1.0, [](double) { return 1.0; });
  EXPECT_TRUE(witness.alive(witness.time_ns + 40 * ms));
  EXPECT_FALSE(witness.alive(witness.time_ns + 60 * ms));
}

TEST(Witness, AfterASilenceItBeginsAnew) {
  Witness witness = of(1.0, [](double) { return 1.0; });
  hear(witness, witness.time_ns + 2'000 * ms, 5.0, 0.1, false, 0.5);
  EXPECT_EQ(witness.mean(Over::short_time), 5.0);
  EXPECT_EQ(witness.mean(Over::long_time), 5.0);
  EXPECT_EQ(witness.heard_s(), 0.0);
}

}  // namespace
}  // namespace odomd::estimator::integrity::witness_test
