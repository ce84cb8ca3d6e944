#include "tools/diagnostics/heading_check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/tools/drives.hpp"

namespace odomd::tools::heading_check_test {
namespace {

using ::testing::HasSubstr;

Trajectory with_yaw(double factor, double offset) {
  Trajectory drive = wavy_drive(0.0, 20.0, 0.01);
  for (auto& point : drive.points) point.pose.yaw = factor * point.pose.yaw + offset;
  return drive;
}

TEST(HeadingCheck, HasNoneOfACarThatDrivesReversesOrDrifts) {
  EXPECT_EQ(heading_warning(with_yaw(1.0, 0.0)), "");
  EXPECT_EQ(heading_warning(with_yaw(1.0, std::numbers::pi)), "");  // backwards
  EXPECT_EQ(heading_warning(with_yaw(1.0, 0.7)), "");               // with a slip angle of 40°
}

TEST(HeadingCheck, SuspectsDegreesAndClockwiseTurns) {
  EXPECT_THAT(heading_warning(with_yaw(180.0 / std::numbers::pi, 0.0)),
              HasSubstr("yaw must be in radians, counter-clockwise"));
  EXPECT_THAT(heading_warning(with_yaw(-1.0, 0.0)), HasSubstr("do not follow the path"));
}

TEST(HeadingCheck, SaysNothingOfACarThatHardlyMoves) {
  Trajectory standing = with_yaw(-1.0, 0.0);
  for (auto& point : standing.points) point.pose.x = point.pose.y = 0.0;
  EXPECT_EQ(heading_warning(standing), "");
}

}  // namespace
}  // namespace odomd::tools::heading_check_test
