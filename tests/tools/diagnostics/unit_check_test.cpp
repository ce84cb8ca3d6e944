#include "tools/diagnostics/unit_check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "tests/tools/drives.hpp"

namespace odomd::tools::unit_check_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr double degree = std::numbers::pi / 180.0;

Trajectory in_units(double metre, double radian) {
  Trajectory drive = moved_by({3.0, -2.0, 1.0}, wavy_drive(0.0, 20.0, 0.03));
  for (auto& point : drive.points)
    point.pose = {metre * point.pose.x, metre * point.pose.y, radian * point.pose.yaw};
  return drive;
}

// A wheel's way and a gyro's turn, both somewhat off.
Trajectory driven(double wheel = 1.05, double gyro = 0.97) {
  Trajectory drive = wavy_drive(0.0, 20.0, 0.01);
  for (auto& point : drive.points)
    point.pose = {wheel * 1e-9 * static_cast<double>(point.t_ns), 0.0, gyro * point.pose.yaw};
  return drive;
}

std::string warning(const Trajectory& poses, const Trajectory& driven) {
  return unit_warning(poses.points, {.trajectory = driven});
}

TEST(UnitCheck, HasNoneOfMetresAndRadians) {
  EXPECT_EQ(warning(in_units(1.0, 1.0), driven()), "");
  EXPECT_EQ(warning(in_units(1.0, -1.0), driven()), "");
  EXPECT_EQ(warning(in_units(30.0, 1.0), driven()), "");
}

TEST(UnitCheck, AsksForMillimetresAndCentimetres) {
  EXPECT_EQ(warning(in_units(1000.0, 1.0), driven()),
            "x and y go about 1000 times as far as the wheels: are the positions in millimetres? "
            "they must be metres");
  EXPECT_THAT(warning(in_units(100.0, 1.0), driven()), HasSubstr("in centimetres? they must be"));
}

TEST(UnitCheck, AsksForDegrees) {
  const std::string of_yaw =
      "yaw turns about 57 times as far as the gyro: is it in degrees? it must be radians";
  EXPECT_EQ(warning(in_units(1.0, 1.0 / degree), driven()), of_yaw);
  EXPECT_EQ(warning(in_units(1000.0, 1.0 / degree), driven()),
            warning(in_units(1000.0, 1.0), driven()) + "; " + of_yaw);
  Trajectory wrapped = in_units(1.0, 1.0 / degree);
  for (auto& point : wrapped.points) point.pose.yaw = std::remainder(point.pose.yaw, 360.0);
  EXPECT_EQ(warning(wrapped, driven()), of_yaw);
}

TEST(UnitCheck, LeavesToWheelsAndGyroWhatIsTheirs) {
  EXPECT_EQ(warning(in_units(1.0, 1.0), driven(0.001, 1.0)), "");
  EXPECT_EQ(warning(in_units(1.0, 1.0), driven(1.0, degree)), "");
  EXPECT_EQ(warning(in_units(1.0, 1.0), driven(3.6, 1.0 / degree)), "");
}

TEST(UnitCheck, IsNotMovedByAFewPosesThatAreWide) {
  Trajectory good = in_units(1.0, 1.0), bad = in_units(1000.0, 1.0 / degree);
  for (std::size_t i = 0; i < good.points.size(); i += 50) {
    good.points[i].pose = {900.0, -900.0, 3.0};
    bad.points[i].pose = {0.0, 0.0, 180.0};
  }
  EXPECT_EQ(warning(good, driven()), "");
  EXPECT_THAT(warning(bad, driven()), HasSubstr("in millimetres?"));
  EXPECT_THAT(warning(bad, driven()), HasSubstr("in degrees?"));
}

TEST(UnitCheck, HoldsPosesAgainstAFilterThatJumpsToo) {
  Trajectory estimate = wavy_drive(0.0, 20.0, 0.01);
  for (std::size_t i = 0; i < estimate.points.size(); ++i)
    estimate.points[i].reset_count = std::floor(0.05 * static_cast<double>(i));
  EXPECT_THAT(warning(in_units(1000.0, 1.0), estimate), HasSubstr("in millimetres?"));
}

TEST(UnitCheck, TakesCameraPosesInAnyOrder) {
  std::vector<estimator::CameraPose> poses;
  for (const TrajectoryPoint& point : in_units(1000.0, 1.0).points) {
    estimator::CameraPose pose;
    pose.capture_ns = point.t_ns;
    pose.x = point.pose.x;
    pose.y = point.pose.y;
    pose.yaw = point.pose.yaw;
    poses.insert(poses.size() % 3 == 0 ? poses.begin() : poses.end(), pose);
  }
  EXPECT_THAT(unit_warning(poses, {.trajectory = driven()}), HasSubstr("in millimetres?"));
  EXPECT_THAT(unit_warning(poses, {.trajectory = driven()}), Not(HasSubstr("degrees")));
}

TEST(UnitCheck, SaysNothingOfACarThatHardlyMoves) {
  EXPECT_EQ(warning(in_units(1000.0, 1.0 / degree), driven(0.01, 0.01)), "");
  EXPECT_EQ(unit_warning(std::span<const TrajectoryPoint>{}, {.trajectory = driven()}), "");
}

}  // namespace
}  // namespace odomd::tools::unit_check_test
