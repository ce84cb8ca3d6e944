#include "tools/diagnostics/heading_check.hpp"
#include "tests/diagnostics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/tools/drives.hpp"

namespace odomd::tools::heading_check_test {
namespace {

using diagnostics::Named;
using ::testing::Optional;

Trajectory with_yaw(double factor, double offset) {
  Trajectory drive = wavy_drive(0.0, 20.0, 0.01);
  for (auto& point : drive.points) point.pose.yaw = factor * point.pose.yaw + offset;
  return drive;
}

TEST(HeadingCheck, HasNoneOfACarThatDrivesReversesOrDrifts) {
  EXPECT_FALSE(check_headings(with_yaw(1.0, 0.0)));
  EXPECT_FALSE(check_headings(with_yaw(1.0, std::numbers::pi)));  // backwards
  EXPECT_FALSE(check_headings(with_yaw(1.0, 0.7)));               // with a slip angle of 40°
}

TEST(HeadingCheck, SuspectsDegreesAndClockwiseTurns) {
  EXPECT_THAT(check_headings(with_yaw(180.0 / std::numbers::pi, 0.0)),
              Optional(Named("headings_off_path")));
  EXPECT_THAT(check_headings(with_yaw(-1.0, 0.0)), Optional(Named("headings_off_path")));
}

TEST(HeadingCheck, SaysNothingOfACarThatHardlyMoves) {
  Trajectory standing = with_yaw(-1.0, 0.0);
  for (auto& point : standing.points) point.pose.x = point.pose.y = 0.0;
  EXPECT_FALSE(check_headings(standing));
}

}  // namespace
}  // namespace odomd::tools::heading_check_test
