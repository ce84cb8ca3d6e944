// The daemon's statistics of samples and of pairs of signals.
#include <limits>

#include "daemon/core/comparison.hpp"
#include "daemon/core/consistency.hpp"
#include "daemon/core/pipeline_statistics.hpp"
#include "tests/gtest.hpp"

namespace odomd::daemon::statistics_test {
namespace {

using estimator::Judgement;

// The wiring tests cover all other comparisons.
TEST(Comparison, StaysFiniteForHugeValues) {
  constexpr Comparison::Bounds plain{0.0, 0.0, 0.1};
  constexpr double memory = 20.0;
  Comparison comparison;
  comparison.add(1e300, -1e300, plain, memory);
  for (int k = 0; k < 200; ++k)
    comparison.add(-3.6 * std::sin(0.7 * k), std::sin(0.7 * k), plain, memory);
  EXPECT_NEAR(comparison.squares(plain).gain(), 3.6, 0.036);
  EXPECT_NEAR(comparison.squares(plain).correlation(), -1.0, 0.01);
}

class ConsistencyTest : public ::testing::Test {
 protected:
  /// Whether the source is inconsistent after `seconds` of 100 samples per second with a constant
  /// νᵀS⁻¹ν. Samples without degrees of freedom are not tested.
  bool after(double squared_ratio, double seconds, int degrees = 1) {
    for (int k = 0; k < std::lround(100.0 * seconds); ++k) {
      t_ns_ += 10'000'000;
      consistency_.take({.degrees = degrees, .squared_ratio = squared_ratio, .time_ns = t_ns_});
      consistency_.update(t_ns_, explained_);
    }
    return consistency_.inconsistent();
  }
  Consistency consistency_;
  bool explained_ = false;
  std::int64_t t_ns_ = 1'000'000'000'000;
};

TEST_F(ConsistencyTest, AcceptsInnovationsThatFitTheCovariance) {
  EXPECT_FALSE(consistency_.inconsistent());
  EXPECT_FALSE(after(1.0, 60.0));
  EXPECT_FALSE(after(3.0, 60.0, 3));
}

TEST_F(ConsistencyTest, RisesAndClearsAfterSeconds) {
  EXPECT_FALSE(after(16.0, 4.0));
  EXPECT_TRUE(after(16.0, 6.0));
  EXPECT_TRUE(after(1.0, 2.0));
  EXPECT_FALSE(after(1.0, 6.0));
}

TEST_F(ConsistencyTest, DividesByTheDegreesOfFreedom) {
  EXPECT_FALSE(after(12.0, 20.0, 3));
  EXPECT_TRUE(after(36.0, 20.0, 3));
}

TEST_F(ConsistencyTest, IgnoresSingleOutliersAndUntestedSamples) {
  static_cast<void>(after(1.0, 1.0));
  static_cast<void>(after(1e9, 0.01));
  static_cast<void>(after(std::numeric_limits<double>::quiet_NaN(), 0.01));
  EXPECT_FALSE(after(1.0, 10.0));
  EXPECT_FALSE(after(100.0, 20.0, 0));
}

TEST_F(ConsistencyTest, DoesNotCountAPause) {
  static_cast<void>(after(16.0, 4.0));
  for (int k = 0; k < 3000; ++k) consistency_.update(t_ns_ += 10'000'000, explained_);
  EXPECT_FALSE(after(16.0, 0.5));
}

TEST_F(ConsistencyTest, ClearsWhenNothingIsTestedAnyMore) {
  EXPECT_TRUE(after(16.0, 20.0));
  EXPECT_TRUE(after(16.0, 4.0, 0));
  EXPECT_FALSE(after(16.0, 2.0, 0));
}

TEST_F(ConsistencyTest, StaysQuietWhileAnotherFaultExplainsIt) {
  explained_ = true;
  EXPECT_FALSE(after(16.0, 20.0));
  explained_ = false;
  EXPECT_FALSE(after(16.0, 4.0)) << "it has to last from then on";
  EXPECT_TRUE(after(16.0, 2.0));
  explained_ = true;
  EXPECT_FALSE(after(16.0, 0.01));
}

Judgement tested(int degrees, double squared_ratio) {
  return {.degrees = degrees,
          .innovation = {0.1, 0.2, 0.3},
          .squared_ratio = squared_ratio,
          .test_ratio = squared_ratio / 20.0};
}

TEST(InnovationStatistics, AverageAllTestedSamples) {
  InnovationStatistics statistics;
  statistics.take(tested(0, 100.0));  // an input
  EXPECT_EQ(statistics.count, 0U);
  EXPECT_EQ(statistics.mean_nis(), 0.0);
  EXPECT_EQ(statistics.inside_95(), 0.0);
  EXPECT_EQ(statistics.test_ratio, 0.0);
  Judgement gated = tested(1, 30.0);
  gated.verdict = estimator::Verdict::gated;
  for (const double ratio : {0.5, 1.5, 3.84}) statistics.take(tested(1, ratio));
  for (const double none : {std::numeric_limits<double>::infinity(), std::nan("")})
    statistics.take(tested(1, none));
  statistics.take(gated);
  EXPECT_EQ(statistics.count, 4U);
  EXPECT_EQ(statistics.dimension, 1U);
  EXPECT_DOUBLE_EQ(statistics.mean_nis(), 35.84 / 4.0);
  EXPECT_EQ(statistics.inside_95(), 0.75);
  EXPECT_EQ(statistics.gated, 1U);
  EXPECT_EQ(statistics.test_ratio, 1.5);
  EXPECT_EQ(statistics.innovation[0], 0.1);
}

TEST(InnovationStatistics, UseThreeDegreesOfFreedomForAPose) {
  Shared<InnovationStatistics> shared;
  for (const double ratio : {7.8, 7.9}) {
    InnovationStatistics statistics = shared.get();
    statistics.take(tested(3, ratio));
    shared.set(statistics);
  }
  EXPECT_EQ(shared.get().inside_95(), 0.5);
  EXPECT_EQ(shared.get().nis_per_degree(), (7.8 + 7.9) / 6.0);
  EXPECT_THAT(shared.get().innovation, ElementsAre(0.1, 0.2, 0.3));
}

}  // namespace
}  // namespace odomd::daemon::statistics_test
