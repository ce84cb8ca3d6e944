#include "tools/tune/trial_log.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "tests/tools/scratch.hpp"

namespace odomd::tools::trial_log_test {
namespace {

using testing::HasSubstr;

const std::vector<Parameter> keys{{.key = "filter.wheel_slip", .from = 0.0, .to = 1.0}};
const std::vector<std::string> drives{"lap1", "lap2"};

TrialOutcome outcome(double position) {
  Score score;
  score.fill(std::numeric_limits<double>::quiet_NaN());
  score[0] = position;
  return {.scores = {score, score}, .impossible = ""};
}

std::string error_of(const std::filesystem::path& file, const std::vector<std::string>& of) {
  try {
    const TrialLog log(file, keys, of);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "none";
}

TEST(TrialLog, FindsWhatAnEarlierRunTried) {
  const Scratch scratch;
  const auto file = scratch.path("tune.state");
  {
    TrialLog log(file, keys, drives);
    EXPECT_EQ(log.find({0.25}), nullptr);
    log.add({std::nullopt}, outcome(1.0));
    log.add({0.1}, outcome(1.0 / 3.0));
    log.add({7.0}, {.scores = {}, .impossible = "car.toml:3: beyond 1"});
  }
  const TrialLog log(file, keys, drives);
  EXPECT_EQ(log.read(), 3U);
  ASSERT_NE(log.find({0.1}), nullptr);
  EXPECT_EQ(log.find({0.1})->scores[1][0], 1.0 / 3.0);  // to the bit
  EXPECT_TRUE(std::isnan(log.find({0.1})->scores[0][1]));
  EXPECT_EQ(log.find({7.0})->impossible, "car.toml:3: beyond 1");
}

TEST(TrialLog, ALastLineThatIsCutOffIsTriedAgain) {
  const Scratch scratch;
  const auto file = scratch.path("tune.state");
  {
    TrialLog log(file, keys, drives);
    log.add({0.1}, outcome(0.5));
    log.add({0.2}, outcome(0.6));
  }
  std::string text = contents(file);
  scratch.write("tune.state", text.substr(0, text.size() - 7));
  {
    TrialLog log(file, keys, drives);
    EXPECT_EQ(log.read(), 1U);
    EXPECT_EQ(log.find({0.2}), nullptr);
    log.add({0.2}, outcome(0.6));
  }
  EXPECT_EQ(contents(file), text);
}

TEST(TrialLog, RefusesWhatIsNotItsOwn) {
  const Scratch scratch;
  const auto file = scratch.path("tune.state");
  { const TrialLog log(file, keys, drives); }
  EXPECT_THAT(error_of(file, {"lap3"}), HasSubstr("tune.state:1: has other keys or drives"));

  EXPECT_THAT(error_of(scratch.write("notes.txt", "buy milk"), drives),
              HasSubstr("notes.txt:1: is not a state file of odom tune"));
  EXPECT_EQ(contents(scratch.path("notes.txt")), "buy milk");

  const std::string text = contents(file);
  EXPECT_THAT(error_of(scratch.write("tune.state", text + "{\"values\":[1]}\n"), drives),
              HasSubstr("tune.state:2: is damaged"));
}

TEST(TrialLog, IsOfOneRunAtATime) {
  const Scratch scratch;
  const auto file = scratch.path("tune.state");
  {
    TrialLog first(file, keys, drives);
    EXPECT_THAT(error_of(file, drives),
                HasSubstr("tune.state: another odom tune is using it; wait for its end"));
    first.add({0.1}, outcome(0.5));
  }
  EXPECT_EQ(TrialLog(file, keys, drives).read(), 1U);
}

TEST(TrialLog, ReportsWhenThePresentConfigurationGivesOtherErrors) {
  const Scratch scratch;
  TrialLog log(scratch.path("tune.state"), keys, drives);
  log.check_unchanged({std::nullopt}, outcome(0.5));  // nothing known: nothing to hold against
  log.add({std::nullopt}, outcome(0.5));
  log.check_unchanged({std::nullopt}, outcome(0.5));
  EXPECT_THROW(log.check_unchanged({std::nullopt}, outcome(0.5000001)), std::invalid_argument);
}

}  // namespace
}  // namespace odomd::tools::trial_log_test
