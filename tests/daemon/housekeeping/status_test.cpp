#include "daemon/housekeeping/status.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "daemon/sockets/json.hpp"

namespace odomd::daemon::status_test {
namespace {

using testing::ElementsAre;

TEST(Percentile, OfNoSamplesIsZero) {
  EXPECT_EQ(percentile_us(std::array<std::uint64_t, ODOM_HISTOGRAM_BUCKETS>{}, 0.5, 0), 0.0);
}

TEST(Percentile, IsTheUpperEdgeOfItsBucket) {
  std::array<std::uint64_t, ODOM_HISTOGRAM_BUCKETS> histogram{};
  histogram[0] = 50;  // below 1 us
  histogram[8] = 49;  // up to 4 us
  histogram[20] = 1;  // up to 32 us
  EXPECT_EQ(percentile_us(histogram, 0.5, 30'000), 1.0);
  EXPECT_EQ(percentile_us(histogram, 0.51, 30'000), 4.0);
  EXPECT_EQ(percentile_us(histogram, 0.99, 30'000), 4.0);
  EXPECT_EQ(percentile_us(histogram, 0.999, 30'000), 30.0) << "no more than the maximum";
}

TEST(Percentile, OfTheLastBucketIsTheMaximum) {
  std::array<std::uint64_t, ODOM_HISTOGRAM_BUCKETS> histogram{};
  histogram.back() = 1;
  EXPECT_EQ(percentile_us(histogram, 0.5, 70'000'000), 70'000.0);
}

TEST(ConditionNames, NameEveryBit) {
  EXPECT_TRUE(condition_names(0).empty());
  EXPECT_THAT(condition_names(ODOM_COND_NOT_REALTIME | ODOM_COND_INPUT_ENDED),
              ElementsAre("not_realtime", "input_ended"));
  EXPECT_THAT(condition_names(ODOM_COND_MISWIRED | ODOM_COND_INCONSISTENT),
              ElementsAre("miswired", "inconsistent"));
  EXPECT_THAT(condition_names(ODOM_COND_BIAS_UNLEARNT | ODOM_COND_SCALE_IMPLAUSIBLE),
              ElementsAre("bias_unlearnt", "scale_implausible"));
  EXPECT_EQ(condition_names(0xFFFF'FFFF).size(), 20U);
}

TEST(Json, IsReadBackAsItWasWritten) {
  JsonWriter json;
  json.begin_object();
  json.member("text", "a\"b\\c\n\x01");
  json.member("bytes", std::string("\xff\xc3"));
  json.member("number", 0.1);
  json.member("large", std::int64_t{-9'007'199'254'740'993});
  json.member("none", std::numeric_limits<double>::quiet_NaN());
  json.member("yes", true);
  json.begin_array("list");
  json.element(1);
  json.begin_object();
  json.end_object();
  json.element("x");
  json.end_array();
  json.begin_object("inner");
  json.member("a", 1);
  json.member("b", 2);
  json.end_object();
  json.end_object();

  const auto read = nlohmann::json::parse(json.text());
  EXPECT_EQ(read["text"], "a\"b\\c\n\x01");
  EXPECT_EQ(read["bytes"], "\u00ff\u00c3");
  EXPECT_EQ(read["number"], 0.1);
  EXPECT_EQ(read["large"], std::int64_t{-9'007'199'254'740'993});
  EXPECT_TRUE(read["none"].is_null());
  EXPECT_EQ(read["yes"], true);
  EXPECT_EQ(read["list"].size(), 3U);
  EXPECT_EQ(read["inner"]["b"], 2);
}

}  // namespace
}  // namespace odomd::daemon::status_test
