// The table of kinds, and faults as they are written on a command line.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "tests/tools/scratch.hpp"
#include "tools/fault/fault.hpp"

namespace odomd::fault::kinds_test {
namespace {

using ::testing::HasSubstr;
using tools::message_of;

TEST(FaultKinds, EachHasANameOfItsOwn) {
  std::set<std::string> names;
  for (const Kind kind : all_kinds()) {
    EXPECT_TRUE(names.insert(name_of(kind)).second) << name_of(kind);
    EXPECT_EQ(parse_kind(name_of(kind)), kind);
  }
  EXPECT_GT(names.size(), 67U);
}

TEST(FaultKinds, AMisspeltOneIsAnsweredWithTheNearest) {
  EXPECT_EQ(message_of([] { (void)parse_kind("gyro.forzen"); }),
            "there is no kind of fault \"gyro.forzen\"; the nearest is 'gyro.frozen'; odom fault "
            "--list shows all");
  EXPECT_THAT(message_of([] { (void)parse_kind("weels.zero"); }), HasSubstr("'wheels.zero'"));
}

TEST(FaultKinds, SourcesAreThoseOfThePart) {
  using estimator::Source;
  EXPECT_EQ(sources_of(parse_kind("gyro.frozen")), only(Source::yaw_rate));
  EXPECT_TRUE(contains(sources_of(parse_kind("wheels.zero")), Source::motor));
  EXPECT_FALSE(contains(sources_of(parse_kind("front_wheels.zero")), Source::wheel_rear_left));
  EXPECT_EQ(sources_of(parse_kind("camera.lost")), only(Source::camera));
  EXPECT_EQ(sources_of(parse_kind("bus.shifted")), 0U);
}

TEST(FaultKinds, AFaultIsWrittenInOneWord) {
  const Fault whole = parse_fault("gyro.biased:10:5:-0.3");
  EXPECT_EQ(whole.kind, parse_kind("gyro.biased"));
  EXPECT_EQ(whole.begin_s, 10.0);
  EXPECT_EQ(whole.duration_s, 5.0);
  EXPECT_EQ(whole.magnitude, -0.3);
  const Fault rest = parse_fault("wheels.scaled:20::1.1");
  EXPECT_TRUE(std::isinf(rest.duration_s));
  EXPECT_EQ(rest.magnitude, 1.1);
  EXPECT_EQ(parse_fault("imu.lost").begin_s, 0.0);
  EXPECT_EQ(parse_fault("accel_x.biased").magnitude, 3.0);
}

TEST(FaultKinds, WhatIsWrongWithAFaultIsNamed) {
  EXPECT_THAT(message_of([] { (void)parse_fault("gyro.zero:ten"); }),
              HasSubstr("the begin \"ten\" is not a number"));
  EXPECT_THAT(message_of([] { (void)parse_fault("gyro.zero:1:0"); }), HasSubstr("has no duration"));
  EXPECT_THAT(message_of([] { (void)parse_fault("gyro.zero:-1"); }),
              HasSubstr("before the first frame"));
  EXPECT_THAT(message_of([] { (void)parse_fault("gyro.zero:1:1:3"); }), HasSubstr("has no size"));
  EXPECT_THAT(message_of([] { (void)parse_fault("imu.bit_flips:::2"); }), HasSubstr("0 to 1"));
  EXPECT_THAT(message_of([] { (void)parse_fault("gyro.zero:1:1:3:4"); }),
              HasSubstr("more parts than"));
  EXPECT_EQ(message_of([] { (void)parse_fault("bus.shifted:::-0.1"); }), "");
}

TEST(FaultKinds, TheListHasThemAll) {
  const auto json = kinds_json();
  EXPECT_EQ(json.size(), all_kinds().size());
  EXPECT_EQ(json[0]["kind"], "gyro.frozen");
  EXPECT_TRUE(json[0]["size"].is_null());
  const std::string text = kinds_text();
  for (const PartInfo& part : parts()) EXPECT_THAT(text, HasSubstr(std::string(part.name)));
  for (const ActInfo& act : acts()) EXPECT_THAT(text, HasSubstr(std::string(act.what)));
  EXPECT_THAT(text, HasSubstr("0.2 rad/s, 3 m/s2"));
}

}  // namespace
}  // namespace odomd::fault::kinds_test
