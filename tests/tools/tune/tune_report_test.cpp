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
      HasSubstr("The sigmas are too small with it: NEES 12.0 on lap, where consistent ones have "
                "3; add nees to the goals.\n"));
  // It was so before, and no worse now.
  EXPECT_THAT(report({"lap", score(0.010, 12.5), score(0.008, 12.0)}), Not(HasSubstr("too small")));
}

TEST(TuneReport, PutsBackAKeyThatHelpsNowhere) {
  EXPECT_EQ(fate_of(1.0, std::nullopt), Fate::idle);
  EXPECT_EQ(fate_of(1.0, 0.998), Fate::idle);  // harms a little
  EXPECT_EQ(fate_of(1.0, 1.002), Fate::taken);
  EXPECT_EQ(fate_of(1.002, 0.998), Fate::taken);
  EXPECT_EQ(fate_of(1.2, 0.99), Fate::over_fitted);
}

TEST(TuneReport, NotesWhatEachKeyDoes) {
  TuneJob job;
  job.drives.resize(1);
  TuneResult result;
  result.relative_error = 0.758;
  TunedKey key;
  key.without = 1.31;
  EXPECT_EQ(note_of(job, result, key),
            "odom tune: helps by +31.0 %; in all 24.2 % better on 1 drive");
}

TEST(TuneReport, SaysThatNoWholeRoundWasLeft) {
  TuneJob job;
  job.goals = {Goal::position};
  job.search.trials = 30;
  TuneResult result;
  result.cut_short = true;
  EXPECT_THAT(as_text(job, result),
              HasSubstr("cut short by --trials 30, which leave no whole round"));
}

TEST(TuneReport, HasADashWhereSigmasCannotBeJudged) {
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(report({"lap", score(0.010, unknown), score(0.008, unknown)}),
              HasSubstr("10.0 > 8.0     -"));
}

}  // namespace
}  // namespace odomd::tools::tune_report_test
