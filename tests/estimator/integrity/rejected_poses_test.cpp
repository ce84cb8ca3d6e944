// Runs of rejected camera poses: which are believed, and what an odometry that is wrong may err by.
#include "estimator/integrity/rejected_poses.hpp"

#include <gtest/gtest.h>

#include <cstdint>

namespace odomd::estimator::rejected_poses_test {
namespace {

constexpr std::int64_t interval_ns = 35'000'000;
constexpr double gate = 16.27;

/// The n-th of a camera that sees the car 3 m and 1 rad off, while the odometry drives 35 mm from
/// one to the next; `side` puts the camera's pose off that.
RejectedPose rejected(int n, double side = 0.0) {
  const Pose2 odom{0.035 * n, 0.0, 0.0};
  Pose2 map = compose({3.0, 0.0, 1.0}, odom);
  map.y += side;
  return {n * interval_ns, map, odom, diagonal(1e-4, 1e-4, 1e-4)};
}

TEST(RejectedRun, IsBelievedAfterTenThatAgree) {
  RejectedRun run;
  for (int n = 1; n <= agreeing_rejections; ++n) {
    EXPECT_EQ(agree(run, rejected(n), gate), n == agreeing_rejections) << n;
    EXPECT_EQ(run.agreeing, n);
  }
}

TEST(RejectedRun, BeginsAnewWithOneThatDoesNotAgree) {
  RejectedRun run;
  for (int n = 1; n < agreeing_rejections; ++n) {
    (void)agree(run, rejected(n), gate);
  }
  EXPECT_FALSE(agree(run, rejected(agreeing_rejections, 2.0), gate));
  EXPECT_EQ(run.agreeing, 1);
}

TEST(RejectedRun, BeginsAnewAfterAPauseAndBackInTime) {
  RejectedRun run;
  EXPECT_FALSE(agree(run, rejected(1), gate));
  EXPECT_FALSE(agree(run, rejected(15), gate));  // 0.49 s
  EXPECT_EQ(run.agreeing, 2);
  EXPECT_FALSE(agree(run, rejected(30), gate));  // 0.525 s
  EXPECT_EQ(run.agreeing, 1);
  EXPECT_FALSE(agree(run, rejected(29), gate));
  EXPECT_EQ(run.agreeing, 1);
}

TEST(SuspectMotion, ErrsByHalfOfItAndByWhatTheTimeAllows) {
  const Symmetric3 P = suspect_motion({1.0, 1.0, 2.0}, {1.3, 1.4, 1.8}, 0.1);
  EXPECT_DOUBLE_EQ(P[0], 0.3 * 0.3);  // half of 0.5 m, and 0.5 m/s
  EXPECT_DOUBLE_EQ(P[3], 0.3 * 0.3);
  EXPECT_NEAR(P[5], 0.2 * 0.2, 1e-15);  // half of 0.2 rad, and 1 rad/s
  EXPECT_EQ(P[1], 0.0);
}

}  // namespace
}  // namespace odomd::estimator::rejected_poses_test
