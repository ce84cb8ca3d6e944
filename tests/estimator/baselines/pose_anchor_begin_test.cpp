// The first pose: from the camera, before or after the first tick, or from a predecessor.
#include "pose_anchor_fixture.hpp"

namespace odomd::estimator::pose_anchor_test {
namespace {

TEST_F(PoseAnchorTest, AbsurdCoordinatesAreGatedEvenWhenInitialising) {
  begin_from_camera();
  drive(100);
  EXPECT_EQ(take(seen({1e300, 0.0, 0.0}, 40 * millisecond)), Verdict::gated);
  EXPECT_FALSE(anchor_.initialised());
}

TEST_F(PoseAnchorTest, FirstCameraPoseInitialises) {
  begin_from_camera();
  drive(100);
  EXPECT_FALSE(anchor_.initialised());
  const std::int64_t latency = 40 * millisecond;
  const Pose2 map{5.0, 6.0, 2.0};
  EXPECT_EQ(take(seen(map, latency)), Verdict::fused);
  EXPECT_TRUE(anchor_.initialised());
  EXPECT_EQ(anchor_.reset_count(), 1U);
  expect_near(anchor_.last_jump(), {}, 0.0);
  expect_near(anchor_.map(), moved(map, velocity, 0.04), 1e-9);
  // The odometry frame starts there too.
  expect_near(anchor_.odom(), anchor_.map(), 1e-12);
  EXPECT_EQ(anchor_.camera_ns(), now_ - latency);
  // Then both move together.
  drive(20);
  expect_near(anchor_.odom(), moved(map, velocity, 0.14), 1e-9);
  expect_positive_definite();
}

TEST_F(PoseAnchorTest, FirstCameraPoseInitialisesThoughTakenBeforeTheHistory) {
  begin_from_camera();
  drive(4);
  const Pose2 map{5.0, 6.0, 2.0};
  EXPECT_EQ(take(seen(map, 32 * millisecond)), Verdict::fused);
  expect_near(anchor_.map(), moved(map, velocity, 0.032), 1e-9);
  expect_near(anchor_.odom(), anchor_.map(), 1e-12);
  // σ² of the camera, and of the path since.
  EXPECT_GT(anchor_.covariance()[0], 1e-4);
  expect_positive_definite();
  // The next one is an ordinary pose.
  drive(7);
  EXPECT_EQ(take(seen(moved(map, velocity, 0.002), 65 * millisecond)), Verdict::too_old);
  EXPECT_EQ(take(seen(moved(map, velocity, 0.062), 5 * millisecond)), Verdict::fused);
  EXPECT_EQ(anchor_.reset_count(), 2U);
}

TEST_F(PoseAnchorTest, NewestCameraPoseBeforeTheHistoryIsWhereItBegins) {
  begin_from_camera();
  EXPECT_EQ(take(seen({1.0, 1.0, 1.0}, 150 * millisecond)), Verdict::fused);
  EXPECT_TRUE(anchor_.initialised());
  const Pose2 map{5.0, 6.0, 2.0};
  EXPECT_EQ(take(seen(map, 40 * millisecond)), Verdict::fused);
  EXPECT_EQ(anchor_.reset_count(), 1U);
  expect_near(anchor_.map(), map, 1e-12);
  expect_near(anchor_.odom(), map, 1e-12);
  drive(20);
  expect_near(anchor_.map(), moved(map, velocity, 0.1), 1e-9);
  expect_positive_definite();
}

TEST_F(PoseAnchorTest, CameraPoseFromBeforeARestartDoesNotMoveIt) {
  begin_from_camera();
  const Pose2 map{5.0, 6.0, 2.0};
  anchor_.resume({.map = map, .covariance = {1e-2, 0.0, 0.0, 1e-2, 0.0, 1e-2}, .reset_count = 3});
  EXPECT_EQ(take(seen({1.0, 1.0, 1.0}, 40 * millisecond)), Verdict::too_old);
  expect_near(anchor_.map(), map, 1e-12);
}

TEST_F(PoseAnchorTest, CameraDoesNotInitialiseUnlessItMay) {
  anchor_ = PoseAnchor{FilterSettings{}};
  drive(100);
  EXPECT_EQ(take(seen({1.0, 1.0, 1.0}, 40 * millisecond)), Verdict::source_off);
  EXPECT_FALSE(anchor_.initialised());
}

}  // namespace
}  // namespace odomd::estimator::pose_anchor_test
