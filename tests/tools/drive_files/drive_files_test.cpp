// Camera logs, pose files and trajectories, written and read.
#include <odom/odom.h>

#include "tests/diagnostics.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/drive_files/drive_tables.hpp"
#include "tools/drive_files/pose_csv.hpp"
#include "tools/drive_files/trajectory.hpp"

namespace odomd::tools::drive_files_test {
namespace {

using diagnostics::Named;

const std::string camera_header = "t_arrival,t_capture,x,y,yaw,sigma_x,sigma_y,sigma_yaw\n";

CameraLog read_camera(const std::string& text) {
  const Scratch scratch;
  return read_camera_log(scratch.write("camera.csv", text));
}

TEST(CameraLog, ReadsEveryColumnExactly) {
  const CameraLog log =
      read_camera(camera_header + "1760000000.032016,1760000000,0.5,-2.5,-0.08,8e-3,0.009,0.01\n");
  EXPECT_THAT(log.poses,
              ElementsAre(testing::FieldsAre(1'760'000'000'000'000'000, 1'760'000'000'032'016'000,
                                             0.5, -2.5, -0.08, 0.008, 0.009, 0.01)));
  EXPECT_THAT(log.warnings, IsEmpty());
}

TEST(CameraLog, IsSortedByArrivalAndKeepsTheOrderOfEqualTimes) {
  const CameraLog log = read_camera(camera_header +
                                    "2,1,20,0,0,1,1,1\n"
                                    "1,0.5,10,0,0,1,1,1\n"
                                    "1,0.6,11,0,0,1,1,1\n");
  std::vector<double> x;
  for (const estimator::CameraPose& pose : log.poses) x.push_back(pose.x);
  EXPECT_THAT(x, ElementsAre(10.0, 11.0, 20.0));
  EXPECT_THAT(log.warnings, ElementsAre(Named("file_content", "not in the order of t_arrival")));
}

TEST(CameraLog, WarnsOfACutOffLastLineAndOfPosesThatArriveBeforeTheyAreCaptured) {
  const CameraLog log = read_camera(camera_header + "1,1,0,0,0,1,1,1\n2,2,0,0,0,1,1,0.0");
  EXPECT_EQ(log.poses.size(), 1U);
  EXPECT_THAT(log.warnings, ElementsAre(Named("file_content", ":3: the last line is cut off")));
  EXPECT_THAT(read_camera(camera_header + "1,1.03,0,0,0,1,1,1\n2,1.97,0,0,0,1,1,1\n").warnings,
              ElementsAre(Named("camera_columns_exchanged", "1 of 2 poses")));
}

TEST(CameraLog, MayBeEmptyButRefusesSigmasThatAreNotPositive) {
  EXPECT_THAT(read_camera(camera_header).poses, IsEmpty());
  for (const char* sigma : {"0", "-0.01", "nan"}) {
    const std::string error =
        message_of([&] { (void)read_camera(camera_header + "1,1,0,0,0,1," + sigma + ",1\n"); });
    EXPECT_THAT(error, HasSubstr("camera.csv:2: column \"sigma_y\"")) << sigma;
  }
}

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
  const std::string header = pose_header();
  EXPECT_THAT(header, StartsWith("t,x,y,yaw,vx,vy,yaw_rate,sigma_x,sigma_y,sigma_yaw,mode,"));

  std::string row;
  append_pose_row(row, some_pose(), 1'760'000'000'005'000'000);
  EXPECT_THAT(row, StartsWith("1760000000.005000000,0.1,0.3333333333333333,7,2,-0.03,1e-07,"
                              "0.5,1,2,dead_reckoning,7,"));
  EXPECT_EQ(std::count(row.begin(), row.end(), ','), std::count(header.begin(), header.end(), ','));
  EXPECT_EQ(row.back(), '\n');
}

TEST(PoseCsv, AppendsTheCalibrationsOfARecord) {
  daemon::TickRecord record{.pose = some_pose()};
  record.details.gyro_bias = 0.01;
  record.details.wheel_scale = 0.98;
  record.details.stiffness_scale = 1.25;
  record.details.steering_latency = 0.04;
  record.details.grip = 8.5;
  record.details.calibration_sigma[0] = 0.000123456;
  record.details.further_calibration_sigma[3] = 2.0;
  std::string columns = pose_header();
  columns.back() = ',';
  EXPECT_EQ(record_header(), columns +
                                 "gyro_bias,gyro_scale,accel_bias_x,accel_bias_y,wheel_scale,"
                                 "steering_offset,stiffness_scale,gyro_latency,wheel_latency,"
                                 "steering_latency,grip,sigma_gyro_bias,sigma_gyro_scale,"
                                 "sigma_accel_bias_x,sigma_accel_bias_y,sigma_wheel_scale,"
                                 "sigma_steering_offset,sigma_stiffness_scale,sigma_gyro_latency,"
                                 "sigma_wheel_latency,sigma_steering_latency,sigma_grip\n");
  std::string pose;
  append_pose_row(pose, record.pose, 5);
  pose.back() = ',';
  std::string row;
  append_record_row(row, record, 5);
  EXPECT_EQ(row, pose + "0.01,0,0,0,0.98,0,1.25,0,0,0.04,8.5,0.0001235,0,0,0,0,0,0,0,0,0,2\n");
}

TEST(PoseCsv, ReadsBackToTheSameBits) {
  const Scratch scratch;
  std::string text = pose_header();
  append_pose_row(text, some_pose(), 5'000'000);

  const Trajectory trajectory = read_trajectory(scratch.write("pose.csv", text));
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

TEST(PoseCsv, ModesHaveTheNamesOfTheClientLibrary) {
  for (std::uint32_t mode = ODOM_INITIALISING; mode <= ODOM_FAULT; ++mode)
    EXPECT_EQ(mode_name(mode), odom_mode_name(mode));
  EXPECT_EQ(mode_name(77), "mode 77");
}

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
  EXPECT_NEAR(half->pose.yaw, 3.14159265, 1e-8);  // the shorter way round, not through 0
  EXPECT_EQ(at(trajectory, 1'000'000'000)->pose.x, 0.0);
  EXPECT_EQ(at(trajectory, 2'000'000'000)->pose.x, 10.0);
  EXPECT_FALSE(at(trajectory, 999'999'999));
  EXPECT_FALSE(at(trajectory, 2'000'000'001));
}

TEST(Trajectory, ReportsWhichColumnsItHas) {
  EXPECT_FALSE(read("t,x,y,yaw\n0,0,0,0\n").has_motion);
  EXPECT_TRUE(read("t,x,y,yaw,vx,vy,yaw_rate\n0,0,0,0,1,2,3\n").has_motion);
  EXPECT_FALSE(read("t,x,y,yaw,sigma_x\n0,0,0,0,1\n").has_covariance);
  EXPECT_EQ(read("t,x,y,yaw,reset_count\n0,0,0,0,3\n").points[0].reset_count, 3.0);
}

TEST(Trajectory, RefusesTimesThatRunBackwardsAndWarnsOfEqualOnes) {
  EXPECT_THAT(error_of("t,x,y,yaw\n0,0,0,0\n2,0,0,0\n1,0,0,0\n"),
              HasSubstr("ref.csv:4: column \"t\": the time runs backwards"));
  EXPECT_THAT(error_of("t,x,y,yaw\n"), HasSubstr("has no rows"));
  // If times are equal, the first row counts.
  const Trajectory trajectory = read("t,x,y,yaw\n0,1,0,0\n0,2,0,0\n0,3,0,0\n1,4,0,0\n");
  ASSERT_EQ(trajectory.points.size(), 2U);
  EXPECT_EQ(trajectory.points[0].pose.x, 1.0);
  EXPECT_THAT(trajectory.warnings,
              ElementsAre(diagnostics::Named(
                  "file_content", "ref.csv:3: column \"t\": a time is repeated (2 rows")));
}

}  // namespace
}  // namespace odomd::tools::drive_files_test
