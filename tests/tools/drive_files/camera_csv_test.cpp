#include "tools/drive_files/camera_csv.hpp"
#include "tests/diagnostics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/tools/scratch.hpp"

namespace odomd::tools::camera_csv_test {
namespace {

using diagnostics::Named;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const std::string header = "t_arrival,t_capture,x,y,yaw,sigma_x,sigma_y,sigma_yaw\n";

CameraLog read(const std::string& text) {
  const Scratch scratch;
  return read_camera_log(scratch.write("camera.csv", text));
}

TEST(CameraLog, ReadsEveryColumnExactly) {
  const CameraLog log =
      read(header + "1760000000.032016,1760000000,0.5,-2.5,-0.08,8e-3,0.009,0.01\n");
  ASSERT_EQ(log.poses.size(), 1U);
  const estimator::CameraPose& pose = log.poses.front();
  EXPECT_EQ(pose.arrival_ns, 1'760'000'000'032'016'000);
  EXPECT_EQ(pose.capture_ns, 1'760'000'000'000'000'000);
  EXPECT_EQ(pose.x, 0.5);
  EXPECT_EQ(pose.y, -2.5);
  EXPECT_EQ(pose.yaw, -0.08);
  EXPECT_EQ(pose.sigma_x, 0.008);
  EXPECT_EQ(pose.sigma_y, 0.009);
  EXPECT_EQ(pose.sigma_yaw, 0.01);
  EXPECT_THAT(log.warnings, IsEmpty());
}

TEST(CameraLog, IsSortedByArrivalAndKeepsTheOrderOfEqualOnes) {
  const CameraLog log = read(header +
                             "2,1,20,0,0,1,1,1\n"
                             "1,0.5,10,0,0,1,1,1\n"
                             "1,0.6,11,0,0,1,1,1\n");
  ASSERT_EQ(log.poses.size(), 3U);
  EXPECT_EQ(log.poses[0].x, 10.0);
  EXPECT_EQ(log.poses[1].x, 11.0);
  EXPECT_EQ(log.poses[2].x, 20.0);
  EXPECT_THAT(log.warnings, ElementsAre(Named("file_content", "not in the order of t_arrival")));
}

TEST(CameraLog, LeavesACutOffLastLineOutWithAWarning) {
  const CameraLog log = read(header + "1,1,0,0,0,1,1,1\n2,2,0,0,0,1,1,0.0");
  EXPECT_EQ(log.poses.size(), 1U);
  EXPECT_THAT(log.warnings, ElementsAre(Named("file_content", ":3: the last line is cut off")));
}

TEST(CameraLog, ReportsPosesThatArriveBeforeTheyAreCaptured) {
  EXPECT_THAT(read(header + "1,1.03,0,0,0,1,1,1\n2,1.97,0,0,0,1,1,1\n").warnings,
              ElementsAre(Named("camera_columns_exchanged", "1 of 2 poses")));
}

TEST(CameraLog, MayHoldNoPose) {
  EXPECT_THAT(read(header).poses, IsEmpty());
}

TEST(CameraLog, RefusesASigmaThatIsNotPositive) {
  for (const char* sigma : {"0", "-0.01", "nan"}) {
    const std::string error =
        message_of([&] { (void)read(header + "1,1,0,0,0,1," + sigma + ",1\n"); });
    EXPECT_THAT(error, HasSubstr("camera.csv:2: column \"sigma_y\"")) << sigma;
  }
}

TEST(CameraLog, RefusesAMissingFile) {
  EXPECT_THAT(message_of([] { (void)read_camera_log("/nonexistent/camera.csv"); }),
              HasSubstr("/nonexistent/camera.csv: no such file"));
}

}  // namespace
}  // namespace odomd::tools::camera_csv_test
