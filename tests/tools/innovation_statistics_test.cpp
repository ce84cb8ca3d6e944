#include "tools/innovation_statistics.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/tools/scratch.hpp"

namespace odomd::tools {
namespace {

using estimator::Judgement;
using estimator::Source;
using estimator::Verdict;

Judgement judged(Source source, int degrees, double squared_ratio,
                 Verdict verdict = Verdict::fused) {
  return {.source = source,
          .verdict = verdict,
          .degrees = degrees,
          .squared_ratio = squared_ratio,
          .test_ratio = squared_ratio / 20.0};
}

TEST(InnovationStatistics, TakeTheMeanOfEachSourceAndTheShareWithinItsChiSquared) {
  InnovationStatistics statistics;
  statistics.add(std::vector{judged(Source::yaw_rate, 1, 0.5), judged(Source::yaw_rate, 1, 3.8)});
  statistics.add(std::vector{judged(Source::yaw_rate, 1, 3.9), judged(Source::camera, 3, 7.8)});
  const auto json = statistics.json();
  ASSERT_EQ(json.size(), 2U);
  EXPECT_EQ(json["yaw_rate"]["count"], 3);
  EXPECT_EQ(json["yaw_rate"]["dimension"], 1);
  EXPECT_DOUBLE_EQ(json["yaw_rate"]["mean_nis"], 8.2 / 3.0);
  EXPECT_DOUBLE_EQ(json["yaw_rate"]["inside_95"], 2.0 / 3.0);
  EXPECT_EQ(json["camera"]["dimension"], 3);
  EXPECT_DOUBLE_EQ(json["camera"]["inside_95"], 1.0);
}

TEST(InnovationStatistics, CountGatedSamplesAndLeaveInputsOut) {
  InnovationStatistics statistics;
  statistics.add(std::vector{judged(Source::camera, 3, 90.0, Verdict::gated),
                             judged(Source::camera, 3, 2.0), judged(Source::steering, 0, 0.0)});
  const auto json = statistics.json();
  ASSERT_EQ(json.size(), 1U);
  EXPECT_EQ(json["camera"]["count"], 2);
  EXPECT_EQ(json["camera"]["gated"], 1);
  EXPECT_DOUBLE_EQ(json["camera"]["mean_nis"], 46.0);
}

TEST(InnovationStatistics, OfTheFullFilterAreInTheReportOfAReplay) {
  const Scratch scratch;
  const std::string drive = scratch.path("drive").string();
  ASSERT_EQ(run_shell("odom sim --duration 8 --out " + drive).status, 0);
  const auto innovations = [&](const std::string& model) {
    const Outcome outcome = run_shell("odom replay --json --config " + drive + "/car.toml --can " +
                                      drive + "/drive.log --camera " + drive +
                                      "/camera.csv --out " + drive + "/pose.csv --model " + model);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return nlohmann::json::parse(outcome.err)["innovations"];
  };
  const auto full = innovations("full");
  EXPECT_GT(full["yaw_rate"]["count"], 1500);
  EXPECT_GT(full["camera"]["count"], 200);
  EXPECT_GT(full["wheel_rear_left"]["inside_95"], 0.5);
  EXPECT_FALSE(full.contains("steering"));
  EXPECT_TRUE(innovations("paper").empty());
}

}  // namespace
}  // namespace odomd::tools
