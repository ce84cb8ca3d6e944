#include "daemon/core/source_watch.hpp"

#include <gtest/gtest.h>

#include <utility>

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

TEST(SourceWatch, FlagsWhatIsRefusedTwiceInARowUntilNothingIsForASecond) {
  using estimator::SourceFlag;
  using estimator::Verdict;
  for (const auto& [verdict, flag] : {std::pair(Verdict::gated, SourceFlag::out_of_range),
                                      std::pair(Verdict::non_finite, SourceFlag::non_finite)}) {
    SourceWatch watch;
    watch.refused(gyro, verdict, 5'000 * ms);
    watch.usable(gyro);
    watch.refused(gyro, verdict, 5'010 * ms);  // one alone, twice
    EXPECT_EQ(watch.flag(gyro), SourceFlag::ok);
    watch.refused(gyro, verdict, 5'020 * ms);
    EXPECT_EQ(watch.flag(gyro), flag);
    watch.usable(gyro);
    watch.settle(6'015 * ms);
    EXPECT_EQ(watch.flag(gyro), flag);
    watch.settle(6'020 * ms);
    EXPECT_EQ(watch.flag(gyro), SourceFlag::ok);
  }
}

TEST(SourceWatch, AUsablePoseInATickCountsMoreThanUnusableOnes) {
  using estimator::SourceFlag;
  constexpr auto camera = static_cast<std::size_t>(estimator::Source::camera);
  for (const bool usable_first : {true, false}) {
    SourceWatch watch;
    if (usable_first) watch.usable_pose();
    for (int i = 0; i < 5; ++i) watch.unusable_pose();
    if (!usable_first) watch.usable_pose();
    watch.settle(5'000 * ms);
    EXPECT_EQ(watch.flag(camera), SourceFlag::ok);
    watch.unusable_pose();
    watch.settle(5'005 * ms);
    EXPECT_EQ(watch.flag(camera), SourceFlag::ok);
    watch.unusable_pose();
    watch.settle(5'010 * ms);
    EXPECT_EQ(watch.flag(camera), SourceFlag::non_finite);
  }
}

}  // namespace
}  // namespace odomd::daemon::source_watch_test
