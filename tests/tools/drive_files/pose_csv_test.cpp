#include "tools/drive_files/pose_csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <odom/odom.h>

#include <algorithm>
#include <sstream>
#include <string>

#include "tests/tools/scratch.hpp"
#include "tools/drive_files/trajectory.hpp"

namespace odomd::tools::pose_csv_test {
namespace {

using ::testing::StartsWith;

odom_pose some_pose() {
  odom_pose pose{};
  pose.tick = 7;
  pose.x = 0.1;
  pose.y = 1.0 / 3.0;
  pose.yaw = 7.0;  // more than a turn
  pose.vx = 2.0;
  pose.vy = -0.03;
  pose.yaw_rate = 1e-7;
  pose.covariance[0] = 0.25;
  pose.covariance[1] = 0.0625;
  pose.covariance[3] = 1.0;
  pose.covariance[5] = 4.0;
  pose.mode = ODOM_DEAD_RECKONING;
  pose.reset_count = 3;
  return pose;
}

TEST(PoseCsv, BeginsWithTheColumnsOfTheContract) {
  std::ostringstream out;
  write_pose_header(out);
  const std::string header = out.str();
  EXPECT_THAT(header, StartsWith("t,x,y,yaw,vx,vy,yaw_rate,sigma_x,sigma_y,sigma_yaw,mode,"));

  std::string row;
  append_pose_row(row, some_pose(), 1'760'000'000'005'000'000);
  EXPECT_THAT(row, StartsWith("1760000000.005000000,0.1,0.3333333333333333,7,2,-0.03,1e-07,"
                              "0.5,1,2,dead_reckoning,7,"));
  EXPECT_EQ(std::count(row.begin(), row.end(), ','), std::count(header.begin(), header.end(), ','));
  EXPECT_EQ(row.back(), '\n');
}

TEST(PoseCsv, ShowsTheCalibrationsOfAWholeRecordBehindItsPose) {
  daemon::TickRecord record{.pose = some_pose()};
  record.details.gyro_bias = 0.01;
  record.details.wheel_scale = 0.98;
  record.details.stiffness_scale = 1.25;
  record.details.steering_latency = 0.04;
  record.details.grip = 8.5;
  std::ostringstream plain;
  std::ostringstream whole;
  write_pose_header(plain);
  write_record_header(whole);
  std::string columns = plain.str();
  columns.back() = ',';
  EXPECT_EQ(whole.str(), columns +
                             "gyro_bias,gyro_scale,accel_bias_x,accel_bias_y,wheel_scale,"
                             "steering_offset,stiffness_scale,gyro_latency,wheel_latency,"
                             "steering_latency,grip\n");
  std::string pose;
  append_pose_row(pose, record.pose, 5);
  pose.back() = ',';
  std::string row;
  append_record_row(row, record, 5);
  EXPECT_EQ(row, pose + "0.01,0,0,0,0.98,0,1.25,0,0,0.04,8.5\n");
}

TEST(PoseCsv, ReadsBackToTheSameBits) {
  const Scratch scratch;
  std::ostringstream text;
  write_pose_header(text);
  std::string row;
  append_pose_row(row, some_pose(), 5'000'000);
  text << row;

  const Trajectory trajectory = read_trajectory(scratch.write("pose.csv", text.str()));
  ASSERT_EQ(trajectory.points.size(), 1U);
  ASSERT_TRUE(trajectory.has_motion);
  ASSERT_TRUE(trajectory.has_covariance);
  const TrajectoryPoint& point = trajectory.points.front();
  EXPECT_EQ(point.t_ns, 5'000'000);
  EXPECT_EQ(point.pose.y, 1.0 / 3.0);
  EXPECT_EQ(point.pose.yaw, 7.0);
  EXPECT_EQ(point.motion.yaw_rate, 1e-7);
  EXPECT_EQ(point.covariance[0], 0.25);
  EXPECT_EQ(point.covariance[1], 0.0625);
  EXPECT_EQ(point.covariance[5], 4.0);
}

TEST(PoseFile, WritesAllRowsInTheirOrder) {
  std::ostringstream expected;
  write_record_header(expected);
  std::ostringstream out;
  PoseFile file(out);
  daemon::TickRecord record{.pose = some_pose()};
  odom_pose& pose = record.pose;
  for (pose.tick = 1; pose.tick <= 10'000; ++pose.tick) {  // several batches
    pose.x = 0.1 * static_cast<double>(pose.tick);
    const auto t_ns = static_cast<std::int64_t>(pose.tick) * 5'000'000;
    record.details.gyro_bias = 0.001 * pose.x;
    file.add(record, t_ns);
    std::string row;
    append_record_row(row, record, t_ns);
    expected << row;
  }
  file.finish();
  EXPECT_EQ(out.str(), expected.str());
}

TEST(PoseFile, OfNothingIsItsHeader) {
  std::ostringstream expected;
  write_record_header(expected);
  std::ostringstream out;
  PoseFile(out).finish();
  EXPECT_EQ(out.str(), expected.str());
}

TEST(PoseCsv, ModesHaveTheNamesOfTheClientLibrary) {
  for (std::uint32_t mode = ODOM_INITIALISING; mode <= ODOM_FAULT; ++mode)
    EXPECT_EQ(mode_name(mode), odom_mode_name(mode));
}

TEST(PoseCsv, AModeThatIsNotKnownHasItsNumber) {
  EXPECT_EQ(mode_name(77), "mode 77");
}

}  // namespace
}  // namespace odomd::tools::pose_csv_test
