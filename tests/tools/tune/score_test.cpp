#include "tools/tune/score.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

namespace odomd::tools::score_test {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
constexpr std::array goals{Goal::position, Goal::heading};

Score score(double position, double heading) {
  Score result;
  result.fill(unknown);
  result[static_cast<std::size_t>(Goal::position)] = position;
  result[static_cast<std::size_t>(Goal::heading)] = heading;
  return result;
}

TEST(TuneScore, IsTheGeometricMeanOfTheRatios) {
  const std::array before{score(1.0, 0.1), score(100.0, 0.1)};
  const std::array tried{score(0.5, 0.1), score(100.0, 0.2)};
  EXPECT_NEAR(relative_error(tried, before, goals), 1.0, 1e-12);  // half of one, twice of another
  const std::array better{score(0.5, 0.05), score(50.0, 0.05)};
  EXPECT_NEAR(relative_error(better, before, goals), 0.5, 1e-12);
}

TEST(TuneScore, UnknownBeforeDoesNotCountAndUnknownAfterwardsIsInfinitelyBad) {
  const std::array<Score, 1> before{score(1.0, unknown)};
  EXPECT_NEAR(relative_error(std::array<Score, 1>{score(0.7, 3.0)}, before, goals), 0.7, 1e-12);
  EXPECT_TRUE(std::isinf(relative_error(std::array<Score, 1>{score(unknown, 3.0)}, before, goals)));
}

TEST(TuneScore, IsMadeOfTheEvaluation) {
  Evaluation evaluation;
  evaluation.position.rms = 0.3;
  evaluation.heading.rms = 0.02;
  evaluation.short_term = HorizonError{.horizon_ns = 35'000'000, .displacement = {.mean = 4e-4}};
  evaluation.horizons = {{.horizon_ns = 5'000'000, .displacement = {.mean = 1e-4}},
                         {.horizon_ns = 1'000'000'000, .displacement = {.mean = 5e-3}}};
  evaluation.consistency = Consistency{.nees = 1.5};
  const Score result = score_of(evaluation);
  EXPECT_EQ(result[static_cast<std::size_t>(Goal::position)], 0.3);
  EXPECT_EQ(result[static_cast<std::size_t>(Goal::heading)], 0.02);
  EXPECT_EQ(result[static_cast<std::size_t>(Goal::prediction)], 4e-4);
  EXPECT_EQ(result[static_cast<std::size_t>(Goal::second)], 5e-3);
  EXPECT_TRUE(std::isnan(result[static_cast<std::size_t>(Goal::end)]));
  EXPECT_EQ(result[static_cast<std::size_t>(Goal::nees)], 1.5);
}

TEST(TuneScore, IsTheWorseTheFurtherNeesIsFromThreeEitherWay) {
  constexpr std::array<Goal, 1> honesty{Goal::nees};
  const auto scored = [](double nees) {
    Score result;
    result.fill(unknown);
    result[static_cast<std::size_t>(Goal::nees)] = nees;
    return std::array<Score, 1>{result};
  };
  EXPECT_NEAR(relative_error(scored(1.5), scored(3.0), honesty), 2.0, 1e-12);
  EXPECT_NEAR(relative_error(scored(6.0), scored(1.5), honesty), 1.0, 1e-12);
}

TEST(TuneScore, JudgesSigmasThatAreTooSmallAndNotThoseThatAreTooLarge) {
  const auto scored = [](double nees) {
    Score result;
    result.fill(unknown);
    result[static_cast<std::size_t>(Goal::nees)] = nees;
    return std::array<Score, 1>{result};
  };
  EXPECT_NEAR(judged_error(scored(8.79), scored(3.71), Goal::nees), 8.79 / 3.71, 1e-12);
  EXPECT_NEAR(judged_error(scored(0.5), scored(2.0), Goal::nees), 1.0, 1e-12);
  EXPECT_NEAR(judged_error(scored(6.0), scored(1.0), Goal::nees), 2.0, 1e-12);
  EXPECT_NEAR(judged_error(scored(unknown), scored(unknown), Goal::nees), 1.0, 1e-12);
  EXPECT_NEAR(judged_error(std::array<Score, 1>{score(1.2, 1.0)},
                           std::array<Score, 1>{score(1.0, 2.0)}, Goal::position),
              1.2, 1e-12);
}

}  // namespace
}  // namespace odomd::tools::score_test
