#include "tools/drive_files/trajectory.hpp"
#include "tests/diagnostics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/tools/scratch.hpp"

namespace odomd::tools::trajectory_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

Trajectory read(const std::string& text) {
  const Scratch scratch;
  return read_trajectory(scratch.write("ref.csv", text));
}

std::string error_of(const std::string& text) {
  return message_of([&] { (void)read(text); });
}

TEST(Trajectory, UnwrapsYaw) {
  const Trajectory trajectory = read("t,x,y,yaw\n0,0,0,3.0\n1,0,0,-3.0\n2,0,0,3.1\n");
  EXPECT_NEAR(trajectory.points[1].pose.yaw, 3.2832, 1e-4);
  EXPECT_NEAR(trajectory.points[2].pose.yaw, 3.1, 1e-12);
}

TEST(Trajectory, InterpolatesBetweenRowsAndNeverBeyondThem) {
  const Trajectory trajectory = read("t,x,y,yaw\n1,0,0,3.0\n2,10,-4,-3.0\n");
  const auto half = at(trajectory, 1'500'000'000);
  ASSERT_TRUE(half);
  EXPECT_EQ(half->pose.x, 5.0);
  EXPECT_EQ(half->pose.y, -2.0);
  EXPECT_NEAR(half->pose.yaw, 3.14159265, 1e-8);  // the shorter way, not through 0
  EXPECT_EQ(at(trajectory, 1'000'000'000)->pose.x, 0.0);
  EXPECT_EQ(at(trajectory, 2'000'000'000)->pose.x, 10.0);
  EXPECT_FALSE(at(trajectory, 999'999'999));
  EXPECT_FALSE(at(trajectory, 2'000'000'001));
}

TEST(Trajectory, ReportsWhatItHas) {
  EXPECT_FALSE(read("t,x,y,yaw\n0,0,0,0\n").has_motion);
  EXPECT_TRUE(read("t,x,y,yaw,vx,vy,yaw_rate\n0,0,0,0,1,2,3\n").has_motion);
  EXPECT_FALSE(read("t,x,y,yaw,sigma_x\n0,0,0,0,1\n").has_covariance);
  EXPECT_EQ(read("t,x,y,yaw,reset_count\n0,0,0,0,3\n").points[0].reset_count, 3.0);
}

TEST(Trajectory, OfEqualTimesTheFirstRowCountsWithAWarning) {
  const Trajectory trajectory = read("t,x,y,yaw\n0,1,0,0\n0,2,0,0\n0,3,0,0\n1,4,0,0\n");
  ASSERT_EQ(trajectory.points.size(), 2U);
  EXPECT_EQ(trajectory.points[0].pose.x, 1.0);
  EXPECT_THAT(trajectory.warnings,
              ElementsAre(diagnostics::Named(
                  "file_content", "ref.csv:3: column \"t\": a time is repeated (2 rows")));
}

TEST(Trajectory, RefusesTimesThatRunBackwardsAndFilesWithoutRows) {
  EXPECT_THAT(error_of("t,x,y,yaw\n0,0,0,0\n2,0,0,0\n1,0,0,0\n"),
              HasSubstr("ref.csv:4: column \"t\": the time runs backwards"));
  EXPECT_THAT(error_of("t,x,y,yaw\n"), HasSubstr("has no rows"));
}

}  // namespace
}  // namespace odomd::tools::trajectory_test
