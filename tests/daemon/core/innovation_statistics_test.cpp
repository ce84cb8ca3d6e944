#include "daemon/core/innovation_statistics.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace odomd::daemon::innovation_statistics_test {
namespace {

using estimator::Judgement;

Judgement tested(int degrees, double squared_ratio) {
  return {.degrees = degrees,
          .innovation = {0.1, 0.2, 0.3},
          .squared_ratio = squared_ratio,
          .test_ratio = squared_ratio / 20.0};
}

TEST(InnovationStatistics, SayNothingBeforeTheFirstTestedSample) {
  InnovationStatistics statistics;
  statistics.take(tested(0, 100.0));  // an input
  EXPECT_EQ(statistics.count(), 0U);
  EXPECT_EQ(statistics.mean_nis(), 0.0);
  EXPECT_EQ(statistics.inside_95(), 0.0);
  EXPECT_EQ(statistics.last_test_ratio(), 0.0);
}

TEST(InnovationStatistics, AverageWhatWasTestedGatedOrNot) {
  InnovationStatistics statistics;
  Judgement gated = tested(1, 30.0);
  gated.verdict = estimator::Verdict::gated;
  for (const double ratio : {0.5, 1.5, 3.84}) statistics.take(tested(1, ratio));
  statistics.take(gated);
  EXPECT_EQ(statistics.count(), 4U);
  EXPECT_EQ(statistics.dimension(), 1);
  EXPECT_DOUBLE_EQ(statistics.mean_nis(), 35.84 / 4.0);
  EXPECT_EQ(statistics.inside_95(), 0.75);
  EXPECT_EQ(statistics.gated(), 1U);
  EXPECT_EQ(statistics.last_test_ratio(), 1.5);
  EXPECT_EQ(statistics.last_innovation()[0], 0.1);
}

TEST(InnovationStatistics, HoldAPoseAgainstThreeDegreesOfFreedom) {
  InnovationStatistics statistics;
  statistics.take(tested(3, 7.8));
  EXPECT_EQ(statistics.inside_95(), 1.0);
  statistics.take(tested(3, 7.9));
  EXPECT_EQ(statistics.inside_95(), 0.5);
  EXPECT_EQ(statistics.dimension(), 3);
  EXPECT_EQ(statistics.last_innovation()[2], 0.3);
}

TEST(InnovationStatistics, AreNotLostToOneThatIsNotFinite) {
  InnovationStatistics statistics;
  statistics.take(tested(1, 2.0));
  statistics.take(tested(1, std::numeric_limits<double>::infinity()));
  statistics.take(tested(1, std::numeric_limits<double>::quiet_NaN()));
  EXPECT_EQ(statistics.count(), 1U);
  EXPECT_EQ(statistics.mean_nis(), 2.0);
}

}  // namespace
}  // namespace odomd::daemon::innovation_statistics_test
