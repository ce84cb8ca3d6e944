// What odom tune says of what it found.
#include "tools/tune/tune_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

namespace odomd::tools::tune_report_test {
namespace {

using testing::AnyOf;
using testing::ContainsRegex;
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
  TuneResult result;
  result.goals = {Goal::position};
  result.relative_error = 0.8;
  result.drives = {lap};
  return as_text({}, result);
}

TEST(TuneReport, ShowsNeesBeforeAndAfterWhateverTheGoalsAre) {
  const std::string text = report({"lap", score(0.010, 2.5), score(0.008, 3.25)});
  EXPECT_THAT(text, HasSubstr("position mm"));
  EXPECT_THAT(text, HasSubstr("NEES"));
  EXPECT_THAT(text, HasSubstr("2.50 > 3.25"));
}

TEST(TuneReport, SaysInWhichGoalsABetterResultIsWorse) {
  TuneResult result;
  result.goals = {Goal::position, Goal::heading};
  result.relative_error = 0.8;
  EXPECT_TRUE(result.is_better());
  result.worse = {{Goal::heading, 1.031, 1.02}};
  EXPECT_FALSE(result.is_better());
  EXPECT_THAT(as_text({}, result),
              HasSubstr("20.0 % better on the drives tuned on, but worse in heading (3.1 % worse): "
                        "keep the present configuration, or take it with --force."));
  EXPECT_THAT(as_json(result), HasSubstr("\"worse_goals\":[\"heading\"]"));
  EXPECT_THAT(as_json(result), HasSubstr("\"better\":false"));
  result.worse = {{Goal::heading, 0.9, 1.02}};
  EXPECT_THAT(as_text({}, result), HasSubstr("heading (2.0 % worse on the drives held out)"));
}

TEST(TuneReport, RecommendsNeesWhereTheSigmasBecomeDishonest) {
  TuneResult result;
  result.relative_error = 0.8;
  result.worse = {{Goal::nees, 2.37, std::nullopt}};
  result.goals = {Goal::position};
  EXPECT_THAT(as_text({}, result),
              HasSubstr("worse in nees (2.4 times as far above 3): keep the present configuration, "
                        "add nees to the goals"));
  result.worse = {{Goal::nees, 1.0, 2.4}};  // no drive tuned on determines it
  EXPECT_THAT(as_text({}, result), Not(HasSubstr("add nees")));
  result.worse = {{Goal::nees, 2.37, std::nullopt}};
  TuneJob forced;
  forced.worse_goals = WorseGoals::allowed;
  EXPECT_THAT(as_text(forced, result), Not(AnyOf(HasSubstr("keep the"), HasSubstr("add nees"))));
  result.goals.push_back(Goal::nees);
  EXPECT_THAT(as_text({}, result), Not(HasSubstr("add nees")));
}

TEST(TuneReport, ShowsTheNumberThatWasInForce) {
  TuneResult result;
  result.keys = {{.key = "filter.wheel_slip", .before = 0.02, .after = 0.03},
                 {.key = "vehicle.grip_rear", .before = std::nullopt, .after = 9.0}};
  const std::string text = as_text({}, result);
  EXPECT_THAT(text, ContainsRegex("filter.wheel_slip +0.02 +0.03"));
  EXPECT_THAT(text, ContainsRegex("vehicle.grip_rear +none +9"));
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
