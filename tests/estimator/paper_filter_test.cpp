// The paper's filter against its author's own, and where it stops.
#include "estimator/paper_filter.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "drive.hpp"
#include "estimator/dynamic_model.hpp"
#include "estimator/filter.hpp"
#include "golden.hpp"

namespace odomd::estimator {
namespace {

using testing::Drive;
using testing::GoldenRow;
using testing::read_golden;
using testing::start;

constexpr double tolerance = 1e-9;

TEST(PaperEkf, AgreesWithTheAuthorsFilter) {
  PaperEkf ekf;
  Pose2 pose;
  double worst = 0.0;
  for (const GoldenRow& row : read_golden()) {
    predict(ekf, {row.steering, row.accel_x});
    correct(ekf, {row.yaw_rate, row.speed});
    pose = moved_euler(pose, {ekf.x[0], ekf.x[1], ekf.x[2]}, ekf.dt);
    const std::array<double, 6> actual{ekf.x[0], ekf.x[1], ekf.x[2], pose.x, pose.y, pose.yaw};
    for (std::size_t i = 0; i < actual.size(); ++i) {
      worst = std::max(worst, std::abs(actual[i] - row.expected[i]));
    }
  }
  EXPECT_LT(worst, tolerance);
  RecordProperty("worst", std::to_string(worst));
}

TEST(PaperFilter, AgreesWithTheAuthorsFilterThroughTheSeam) {
  Drive drive = start(Model::paper);
  std::size_t step = 0;
  for (const GoldenRow& row : read_golden()) {
    const Estimate e = drive.tick({.speed = row.speed,
                                   .steering = row.steering,
                                   .yaw_rate = row.yaw_rate,
                                   .accel_x = row.accel_x});
    ASSERT_TRUE(e.initialised);
    const std::array<double, 6> in_map{e.v_x, e.v_y, e.yaw_rate, e.map.x, e.map.y, e.map.yaw};
    for (std::size_t i = 0; i < in_map.size(); ++i) {
      ASSERT_NEAR(in_map[i], row.expected[i], tolerance) << "column " << i << ", step " << step;
    }
    ASSERT_EQ(e.map.x, e.odom.x);
    ASSERT_EQ(e.map.yaw, e.odom.yaw);
    ++step;
  }
  EXPECT_EQ(step, 4000U);
}

}  // namespace
}  // namespace odomd::estimator
