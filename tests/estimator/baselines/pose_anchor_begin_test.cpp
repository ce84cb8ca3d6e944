// The first pose: from the camera, before or after the first tick, or from a predecessor.
#include "pose_anchor_fixture.hpp"

namespace odomd::estimator::testing::pose_anchor_test {
namespace {

TEST_F(PoseAnchorTest, FirstCameraPoseInitialises) {
  begin_from_camera();
  drive(100);
  EXPECT_EQ(take(seen({1e300, 0.0, 0.0}, 50 * millisecond)), Verdict::gated);
  EXPECT_FALSE(anchor_.initialised());
  const std::int64_t latency = 40 * millisecond;
  const Pose2 map{5.0, 6.0, 2.0};
  EXPECT_EQ(take(seen(map, latency)), Verdict::fused);
  EXPECT_TRUE(anchor_.initialised());
  EXPECT_EQ(anchor_.reset_count(), 1U);
  EXPECT_THAT(anchor_.last_jump(), PoseNear(Pose2{}, 0.0));
  EXPECT_THAT(anchor_.map(), PoseNear(moved(map, velocity, 0.04), 1e-9));
  // The odometry frame starts at the same pose.
  EXPECT_THAT(anchor_.odom(), PoseNear(anchor_.map(), 1e-12));
  EXPECT_EQ(anchor_.camera_ns(), now_ - latency);
  // Then both poses move together.
  drive(20);
  EXPECT_THAT(anchor_.odom(), PoseNear(moved(map, velocity, 0.14), 1e-9));
}

TEST_F(PoseAnchorTest, FirstCameraPoseInitialisesEvenIfOlderThanTheHistory) {
  begin_from_camera();
  drive(4);
  const Pose2 map{5.0, 6.0, 2.0};
  EXPECT_EQ(take(seen(map, 32 * millisecond)), Verdict::fused);
  EXPECT_THAT(anchor_.map(), PoseNear(moved(map, velocity, 0.032), 1e-9));
  EXPECT_THAT(anchor_.odom(), PoseNear(anchor_.map(), 1e-12));
  // σ² of the camera, and of the path since.
  EXPECT_GT(anchor_.covariance()[0], 1e-4);
  // The next camera pose does not initialise.
  drive(7);
  EXPECT_EQ(take(seen(moved(map, velocity, 0.002), 65 * millisecond)), Verdict::too_old);
  EXPECT_EQ(take(seen(moved(map, velocity, 0.062), 5 * millisecond)), Verdict::fused);
  EXPECT_EQ(anchor_.reset_count(), 2U);
}

TEST_F(PoseAnchorTest, StartsAtTheNewestCameraPoseBeforeTheFirstTick) {
  begin_from_camera();
  EXPECT_EQ(take(seen({1.0, 1.0, 1.0}, 150 * millisecond)), Verdict::fused);
  EXPECT_TRUE(anchor_.initialised());
  const Pose2 map{5.0, 6.0, 2.0};
  EXPECT_EQ(take(seen(map, 40 * millisecond)), Verdict::fused);
  EXPECT_EQ(anchor_.reset_count(), 1U);
  EXPECT_THAT(anchor_.map(), PoseNear(map, 1e-12));
  EXPECT_THAT(anchor_.odom(), PoseNear(map, 1e-12));
  drive(20);
  EXPECT_THAT(anchor_.map(), PoseNear(moved(map, velocity, 0.1), 1e-9));
}

TEST_F(PoseAnchorTest, CameraPoseFromBeforeARestartDoesNotMoveIt) {
  begin_from_camera();
  const Pose2 map{5.0, 6.0, 2.0};
  anchor_.resume({.map = map, .covariance = {1e-2, 0.0, 0.0, 1e-2, 0.0, 1e-2}, .reset_count = 3});
  EXPECT_EQ(take(seen({1.0, 1.0, 1.0}, 40 * millisecond)), Verdict::too_old);
  EXPECT_THAT(anchor_.map(), PoseNear(map, 1e-12));
}

}  // namespace
}  // namespace odomd::estimator::testing::pose_anchor_test
