#include "tools/evaluation/drive_evaluation.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace odomd::tools::score_test {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

Score score(double position, double heading) {
  return {unknown, unknown, position, heading};
}

TEST(Score, IsTheGeometricMeanOfTheRatios) {
  const std::array before{score(1.0, 0.1), score(100.0, 0.1)};
  const std::array tried{score(0.5, 0.1), score(100.0, 0.2)};
  EXPECT_NEAR(relative_error(tried, before), 1.0, 1e-12);  // half of one, twice of another
  const std::array better{score(0.5, 0.05), score(50.0, 0.05)};
  EXPECT_NEAR(relative_error(better, before), 0.5, 1e-12);
}

TEST(Score, UnknownBeforeDoesNotCountAndUnknownAfterwardsIsInfinitelyBad) {
  const std::vector<Score> before{score(1.0, unknown)};
  EXPECT_NEAR(relative_error(std::vector{score(0.7, 3.0)}, before), 0.7, 1e-12);
  EXPECT_TRUE(std::isinf(relative_error(std::vector{score(unknown, 3.0)}, before)));
}

TEST(Score, IsMadeOfTheEvaluation) {
  Evaluation evaluation;
  evaluation.position.rms = 0.3;
  evaluation.heading.rms = 0.02;
  evaluation.horizons = {{.horizon_ns = 5'000'000, .displacement = {.mean = 1e-4}},
                         {.horizon_ns = 1'000'000'000, .displacement = {.mean = 5e-3}}};
  EXPECT_TRUE(std::isnan(score_of(evaluation)[0]));
  evaluation.short_term = HorizonError{.horizon_ns = 35'000'000, .displacement = {.mean = 4e-4}};
  EXPECT_EQ(score_of(evaluation), (Score{4e-4, 5e-3, 0.3, 0.02}));
}

}  // namespace
}  // namespace odomd::tools::score_test
