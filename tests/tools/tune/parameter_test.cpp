#include "tools/tune/parameter.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

namespace odomd::tools::parameter_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(TunedParameter, ARangeAboveZeroIsWalkedInProportion) {
  const Parameter parameter = parse_parameter("filter.wheel_slip=0.01:1");
  EXPECT_EQ(parameter.key, "filter.wheel_slip");
  EXPECT_TRUE(parameter.values.empty());
  EXPECT_DOUBLE_EQ(value_at(parameter, 0.0), 0.01);
  EXPECT_DOUBLE_EQ(value_at(parameter, 0.5), 0.1);
  EXPECT_DOUBLE_EQ(value_at(parameter, 1.0), 1.0);
  EXPECT_DOUBLE_EQ(place_of(parameter, 0.1), 0.5);
}

TEST(TunedParameter, ARangeThroughZeroIsWalkedEvenly) {
  const Parameter parameter = parse_parameter("imu.position[0]=-0.1:0.3");
  EXPECT_DOUBLE_EQ(value_at(parameter, 0.5), 0.1);
  EXPECT_DOUBLE_EQ(place_of(parameter, 0.2), 0.75);
  EXPECT_DOUBLE_EQ(place_of(parameter, 7.0), 1.0);  // held to the range
}

TEST(TunedParameter, ValuesHaveFourDigits) {
  EXPECT_DOUBLE_EQ(value_at(parse_parameter("a.b=1:7"), 1.0 / 3.0), 1.913);
}

TEST(TunedParameter, ValuesToSweepAreCountedOrNamed) {
  EXPECT_THAT(parse_parameter("a.b=1:100:3").values, ElementsAre(1.0, 10.0, 100.0));
  EXPECT_THAT(parse_parameter("a.b=0,2.5,-1").values, ElementsAre(0.0, 2.5, -1.0));
}

TEST(TunedParameter, WhatIsNoRangeIsRefusedWithAnExample) {
  for (const char* text :
       {"", "=1:2", "a.b", "a.b=", "a.b=2:1", "a.b=1:1", "a.b=1:2:1", "a.b=1:2:2.5", "a.b=1:2:3:4",
        "a.b=1:x", "a.b=1:inf", "a.b=1,,2", "a.b=1:2:100000"}) {
    try {
      (void)parse_parameter(text);
      FAIL() << text;
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), HasSubstr("--set")) << text;
      EXPECT_THAT(error.what(), HasSubstr("0.01:0.2:5")) << text;
    }
  }
}

}  // namespace
}  // namespace odomd::tools::parameter_test
