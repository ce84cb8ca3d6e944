#include "daemon/core/consistency.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace odomd::daemon::consistency_test {
namespace {

class ConsistencyTest : public ::testing::Test {
 protected:
  // Samples with one νᵀS⁻¹ν for some seconds, 100 per second.
  void take(double squared_ratio, double seconds, int degrees = 1) {
    for (int k = 0; k < static_cast<int>(100.0 * seconds); ++k) {
      t_ns_ += 10'000'000;
      consistency_.take({.degrees = degrees, .squared_ratio = squared_ratio, .time_ns = t_ns_});
      consistency_.look(t_ns_, explained_);
    }
  }
  void wait(double seconds) {
    for (int k = 0; k < static_cast<int>(100.0 * seconds); ++k) {
      t_ns_ += 10'000'000;
      consistency_.look(t_ns_, explained_);
    }
  }
  Consistency consistency_;
  bool explained_ = false;
  std::int64_t t_ns_ = 1'000'000'000'000;
};

TEST_F(ConsistencyTest, IsCalmWhereTheFilterKnowsItsUncertainty) {
  EXPECT_FALSE(consistency_.inconsistent());
  take(1.0, 60.0);
  take(3.0, 60.0, 3);
  EXPECT_FALSE(consistency_.inconsistent());
}

TEST_F(ConsistencyTest, TakesSecondsToBeRaisedAndToGo) {
  take(16.0, 4.0);
  EXPECT_FALSE(consistency_.inconsistent());
  take(16.0, 6.0);
  EXPECT_TRUE(consistency_.inconsistent());
  take(1.0, 2.0);
  EXPECT_TRUE(consistency_.inconsistent());
  take(1.0, 6.0);
  EXPECT_FALSE(consistency_.inconsistent());
}

TEST_F(ConsistencyTest, CountsADegreeOfFreedom) {
  take(12.0, 20.0, 3);
  EXPECT_FALSE(consistency_.inconsistent());
  take(36.0, 20.0, 3);
  EXPECT_TRUE(consistency_.inconsistent());
}

TEST_F(ConsistencyTest, PassesOverOneSampleThatIsWideOfTheMarkAndWhatIsNotTested) {
  take(1.0, 1.0);
  take(1e9, 0.01);
  take(std::numeric_limits<double>::quiet_NaN(), 0.01);
  take(1.0, 10.0);
  take(100.0, 20.0, 0);
  EXPECT_FALSE(consistency_.inconsistent());
}

TEST_F(ConsistencyTest, DoesNotCountAPause) {
  take(16.0, 4.0);
  wait(30.0);
  take(16.0, 0.5);
  EXPECT_FALSE(consistency_.inconsistent());
}

TEST_F(ConsistencyTest, GoesWhereNothingIsTestedAnyMore) {
  take(16.0, 20.0);
  take(16.0, 4.0, 0);
  EXPECT_TRUE(consistency_.inconsistent());
  take(16.0, 2.0, 0);
  EXPECT_FALSE(consistency_.inconsistent());
}

TEST_F(ConsistencyTest, SaysNothingWhileSomethingElseIsKnownToBeWrong) {
  explained_ = true;
  take(16.0, 20.0);
  EXPECT_FALSE(consistency_.inconsistent());
  explained_ = false;
  take(16.0, 4.0);
  EXPECT_FALSE(consistency_.inconsistent()) << "it has to last from then on";
  take(16.0, 2.0);
  EXPECT_TRUE(consistency_.inconsistent());
  explained_ = true;
  take(16.0, 0.01);
  EXPECT_FALSE(consistency_.inconsistent());
}

}  // namespace
}  // namespace odomd::daemon::consistency_test
