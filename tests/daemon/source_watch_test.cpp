#include "daemon/source_watch.hpp"

#include <gtest/gtest.h>

namespace odomd::daemon::source_watch_test {
namespace {

constexpr std::size_t gyro = 0;
constexpr std::int64_t ms = 1'000'000;

TEST(SourceWatch, KnowsNoAgeBeforeTheFirstSample) {
  SourceWatch watch;
  watch.configure(gyro, 30 * ms);
  EXPECT_EQ(watch.age_ns(gyro, 100 * ms), -1);
  EXPECT_FALSE(watch.healthy(gyro, 100 * ms));
}

TEST(SourceWatch, GivesANeverHeardSourceItsTimeoutFromTheStart) {
  SourceWatch watch;
  watch.configure(gyro, 30 * ms);
  EXPECT_FALSE(watch.overdue(gyro, 130 * ms, 100 * ms));
  EXPECT_TRUE(watch.overdue(gyro, 131 * ms, 100 * ms));
}

TEST(SourceWatch, CountsAgeFromWhenTheSampleWasTakenAndTimeoutFromWhenItWasHeard) {
  SourceWatch watch;
  watch.configure(gyro, 30 * ms);
  watch.heard(gyro, 100 * ms, 60 * ms);  // 40 ms of known latency, longer than the time-out
  EXPECT_EQ(watch.age_ns(gyro, 110 * ms), 50 * ms);
  EXPECT_TRUE(watch.healthy(gyro, 110 * ms));
  EXPECT_TRUE(watch.overdue(gyro, 131 * ms, 0));
  EXPECT_FALSE(watch.healthy(gyro, 131 * ms));
}

TEST(SourceWatch, NeverCallsAnUnconfiguredSourceOverdueOrHealthy) {
  SourceWatch watch;
  watch.heard(gyro, 100 * ms, 100 * ms);
  EXPECT_FALSE(watch.overdue(gyro, 10'000 * ms, 0));
  EXPECT_FALSE(watch.healthy(gyro, 100 * ms));
}

TEST(SourceWatch, FailsWithItsProtectionUntilTheNextGoodSample) {
  SourceWatch watch;
  watch.configure(gyro, 30 * ms);
  watch.heard(gyro, 100 * ms, 100 * ms);
  watch.failed(gyro);
  EXPECT_TRUE(watch.failing(gyro));
  EXPECT_FALSE(watch.healthy(gyro, 101 * ms));
  watch.heard(gyro, 105 * ms, 105 * ms);
  EXPECT_TRUE(watch.healthy(gyro, 106 * ms));
}

}  // namespace
}  // namespace odomd::daemon::source_watch_test
