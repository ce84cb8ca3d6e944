// What odom tune says of what it found.
#include "tools/tune/tune_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace odomd::tools::tune_report_test {
namespace {

using testing::HasSubstr;
using testing::Not;

Score score(double position, double nees) {
  Score result;
  result.fill(std::numeric_limits<double>::quiet_NaN());
  result[static_cast<std::size_t>(Goal::position)] = position;
  result[static_cast<std::size_t>(Goal::nees)] = nees;
  return result;
}

std::string report(const DriveScores& lap) {
  TuneJob job;
  job.goals = {Goal::position};
  TuneResult result;
  result.relative_error = 0.8;
  result.drives = {lap};
  return as_text(job, result);
}

TEST(TuneReport, ShowsNeesBeforeAndAfterWhateverTheGoalsAre) {
  const std::string text = report({"lap", score(0.010, 2.5), score(0.008, 3.25)});
  EXPECT_THAT(text, HasSubstr("position mm"));
  EXPECT_THAT(text, HasSubstr("NEES"));
  EXPECT_THAT(text, HasSubstr("2.50 > 3.25"));
  EXPECT_THAT(text, Not(HasSubstr("too small")));
}

TEST(TuneReport, SaysThatABetterOptimumIsOverconfident) {
  EXPECT_THAT(
      report({"lap", score(0.010, 2.5), score(0.008, 12.04)}),
      HasSubstr("The sigmas are too small with it: NEES 12.0 on lap, where honest ones have "
                "3; have nees among the goals.\n"));
  // It was so before, and no worse now.
  EXPECT_THAT(report({"lap", score(0.010, 12.5), score(0.008, 12.0)}), Not(HasSubstr("too small")));
}

TEST(TuneReport, HasADashWhereSigmasCannotBeJudged) {
  const double untold = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(report({"lap", score(0.010, untold), score(0.008, untold)}),
              HasSubstr("10.0 > 8.0     -"));
}

}  // namespace
}  // namespace odomd::tools::tune_report_test
