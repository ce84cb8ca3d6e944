// Late camera poses with a known odometry: which ones re-anchor, and which are rejected.
#include <functional>
#include <limits>

#include "pose_anchor_fixture.hpp"

namespace odomd::estimator::testing::pose_anchor_test {
namespace {

TEST_F(PoseAnchorTest, LatePoseReAnchorsAtItsCaptureTime) {
  // The true map frame is elsewhere; the pose is from between two ticks, or after the last one.
  const Pose2 true_anchor{0.02, -0.03, 0.01};
  for (const std::int64_t latency : {std::int64_t{41'300'000}, -2 * millisecond}) {
    begin();
    drive(100);
    const Pose2 before = anchor_.map();
    ASSERT_EQ(take(seen_at(true_anchor, latency)), Verdict::fused);
    EXPECT_THAT(anchor_.map(), PoseNear(compose(true_anchor, odom_at(now_)), 1e-9));
    EXPECT_THAT(anchor_.odom(), PoseNear(odom_at(now_), 1e-12));
    EXPECT_EQ(anchor_.reset_count(), 2U);
    EXPECT_EQ(anchor_.camera_ns(), now_ - latency);
    EXPECT_THAT(anchor_.last_jump(), PoseNear(anchor_.map() - before, 0.0));
    EXPECT_LT(anchor_.test_ratio(), 1.0);
  }
}

TEST_F(PoseAnchorTest, ReAnchoringManyTimesKeepsTheOdometry) {
  for (int i = 0; i < 200; ++i) {
    drive(7);
    const Pose2 small{0.01 * std::sin(i), 0.01 * std::cos(3.0 * i), 0.005 * std::sin(2.0 * i)};
    ASSERT_EQ(take(seen_at(small, 35 * millisecond)), Verdict::fused);
    EXPECT_THAT(anchor_.map(), PoseNear(compose(small, odom_at(now_)), 1e-5));
  }
  EXPECT_THAT(anchor_.odom(), PoseNear(odom_at(now_), 1e-11));
}

TEST_F(PoseAnchorTest, YawStaysContinuousThoughTheCameraWraps) {
  drive(2000);  // 20 rad
  const double yaw = anchor_.map().yaw;
  ASSERT_GT(yaw, 19.0);
  Pose2 map = odom_at(now_ - 20 * millisecond);
  map.yaw = wrap_angle(map.yaw + 0.01);
  ASSERT_EQ(take(seen(map, 20 * millisecond)), Verdict::fused);
  EXPECT_NEAR(anchor_.map().yaw, yaw + 0.01, 1e-9);
}

TEST_F(PoseAnchorTest, CovarianceIsTheCamerasPropagatedSinceCapture) {
  drive(100);
  const double sigma = 0.004;
  ASSERT_EQ(take(seen_at({}, 40 * millisecond, sigma)), Verdict::fused);
  // The expected covariance: the camera's own, propagated over eight ticks.
  Eigen::Matrix3d P = sigma * sigma * Eigen::Matrix3d::Identity();
  Pose2 pose = odom_at(now_ - 40 * millisecond);
  for (int i = 0; i < 8; ++i) {
    const Pose2 next = moved(pose, velocity, 0.005);
    const Symmetric3 V = rotated(velocity_covariance, std::cos(pose.yaw), std::sin(pose.yaw));
    const Eigen::Matrix3d F = displacement(next.x - pose.x, next.y - pose.y);
    P = F * P * F.transpose() + 0.005 * 0.005 * unpacked(V);
    pose = next;
  }
  EXPECT_LT((unpacked(anchor_.covariance()) - P).cwiseAbs().maxCoeff(), 1e-7 * sigma * sigma);
}

TEST_F(PoseAnchorTest, CovarianceStaysPositiveDefiniteAndBounded) {
  // 1.4 hours.
  for (int i = 0; i < 1000; ++i) {
    drive(1000);
    ASSERT_FALSE(HasFailure()) << i;
  }
  EXPECT_LE(anchor_.covariance()[0], 1e6);
  EXPECT_LE(anchor_.covariance()[5], 9.87);
}

TEST_F(PoseAnchorTest, GateIsAtTheChiSquareOfTheSettingsAndAGatedPoseChangesNothing) {
  // ν along x alone: ν² / (P + R) against 16.27. A small yaw sigma keeps P diagonal.
  const double sigma = 0.12;  // S = 0.05² + 0.12² = 0.13²
  const auto off_by = [&](double edges) {
    drive(1);
    Pose2 map = anchor_.map();
    map.x += edges * std::sqrt(16.27) * 0.13;
    return take(seen(map, 0, sigma));
  };
  EXPECT_EQ(off_by(1.01), Verdict::gated);
  EXPECT_GT(anchor_.test_ratio(), 1.0);
  EXPECT_THAT(anchor_.map(), PoseNear(anchor_.odom(), 0.0));
  EXPECT_EQ(anchor_.reset_count(), 1U);
  EXPECT_EQ(anchor_.camera_ns(), 0);
  EXPECT_EQ(off_by(0.99), Verdict::fused);
  EXPECT_NEAR(anchor_.test_ratio(), 0.98, 0.01);
}

TEST_F(PoseAnchorTest, ConsistentRejectedPosesAreAcceptedAfterTen) {
  const Pose2 true_anchor{3.0, -1.0, 1.0};
  drive(50);
  for (int i = 1; i <= PoseAnchor::rejections_to_accept; ++i) {
    drive(7);
    const Verdict expected = i < PoseAnchor::rejections_to_accept ? Verdict::gated : Verdict::fused;
    ASSERT_EQ(take(seen_at(true_anchor, 40 * millisecond)), expected) << i;
  }
  EXPECT_THAT(anchor_.map(), PoseNear(compose(true_anchor, odom_at(now_)), 1e-5));
  EXPECT_EQ(anchor_.reset_count(), 2U);
  EXPECT_GT(anchor_.test_ratio(), 1.0);
}

TEST_F(PoseAnchorTest, OnlyAnUnbrokenRunOfRejectedPosesThatAgreeIsAccepted) {
  constexpr int most = PoseAnchor::rejections_to_accept;
  const Pose2 elsewhere{3.0, -1.0, 1.0};
  constexpr std::int64_t late = 40 * millisecond;
  struct Run {
    const char* name;
    int poses;
    std::function<CameraPose(int)> pose;  ///< the i-th, from 1 on
    std::function<bool(int)> accepted = [](int) { return false; };
    std::function<int(int)> ticks = [](int) { return 7; };
  };
  const Run runs[] = {
      {"poses that contradict each other", 100,
       [&](int i) {
         const double side = i % 2 == 0 ? 4.0 : -4.0;
         return seen({side, side, 0.0}, late);
       }},
      {"starts again 2 m farther ahead at the tenth pose", 2 * most - 1,
       [&](int i) {
         return seen_at({i < most ? 3.0 : 5.0, -1.0, 1.0}, 0);
       },
       [&](int i) { return i == 2 * most - 1; }},
      {"every second picture is older than the one before", 2 * most,
       [&](int i) { return seen_at(elsewhere, i % 2 == 0 ? late : 0); }},
      {"a pause ends it", 30, [&](int) { return seen_at(elsewhere, late); },
       [](int) { return false; }, [](int i) { return i % 9 == 0 ? 101 : 7; }},
      {"one good pose ends it", 30,
       [&](int i) { return seen_at(i % 9 == 0 ? Pose2{} : elsewhere, late); },
       [](int i) { return i % 9 == 0; }},
  };
  for (const Run& run : runs) {
    SCOPED_TRACE(run.name);
    begin();
    drive(50);
    for (int i = 1; i <= run.poses; ++i) {
      drive(run.ticks(i));
      ASSERT_EQ(take(run.pose(i)), run.accepted(i) ? Verdict::fused : Verdict::gated) << i;
    }
  }
}

TEST_F(PoseAnchorTest, CameraIsAcceptedWhileTheWheelsSpin) {
  // The car moves at a fifth of the measured speed, and turns half as fast.
  drive(50);
  Pose2 truth = anchor_.map();
  const auto spin = [&](int ticks) {
    drive(ticks);
    truth = moved(truth, {0.2 * velocity.v_x, 0.0, 0.5 * velocity.yaw_rate}, 0.005 * ticks);
  };
  int rejected = 0;
  double worst = 0.0;
  for (int i = 0; i < 280; ++i) {  // ten seconds
    spin(7);
    rejected += take(seen(truth, 0)) == Verdict::gated ? 1 : 0;
    if (i > 28)
      worst = std::max(worst, std::hypot(anchor_.map().x - truth.x, anchor_.map().y - truth.y));
  }
  EXPECT_LT(rejected, 280 / 4);
  // The error grows at most for the length of a run of rejected poses.
  EXPECT_LT(worst, 0.8 * 0.035 * (PoseAnchor::rejections_to_accept + 4));
}

TEST_F(PoseAnchorTest, DistrustShowsInTheCovarianceAndPasses) {
  const Pose2 true_anchor{3.0, -1.0, 1.0};
  drive(50);
  for (int i = 0; i < PoseAnchor::rejections_to_accept; ++i) {
    drive(7);
    take(seen_at(true_anchor, 0));
  }
  ASSERT_EQ(anchor_.reset_count(), 2U);
  const auto sigma_after_a_gap = [&] {
    drive(7);
    EXPECT_EQ(take(seen_at(true_anchor, 0)), Verdict::fused);
    drive(7);
    return std::sqrt(anchor_.covariance()[0]);
  };
  // σ: 7 ticks at a speed error of 0.5 m/s plus half the speed (1 m/s), and the camera's 10 mm.
  EXPECT_NEAR(sigma_after_a_gap(), std::hypot(0.010, 7 * 0.005 * 1.0), 0.005);
  drive(400);
  EXPECT_NEAR(sigma_after_a_gap(), 0.010, 0.001);
}

TEST_F(PoseAnchorTest, PoseIsAcceptedAgainOnceTheUncertaintyHasGrown) {
  drive(50);
  const Pose2 off{0.35, 0.0, 0.0};
  EXPECT_EQ(take(seen_at(off, 40 * millisecond)), Verdict::gated);
  drive(4000, 1000.0);
  EXPECT_EQ(take(seen_at(off, 40 * millisecond)), Verdict::fused);
}

TEST_F(PoseAnchorTest, GivesEveryPoseItsVerdict) {
  drive(400);
  using Limits = std::numeric_limits<std::int64_t>;
  const auto taken_at = [&](std::int64_t capture_ns) {
    CameraPose camera = seen(odom_at(now_), 0);
    camera.capture_ns = capture_ns;
    return camera;
  };
  CameraPose infinite = seen_at({}, 40 * millisecond);
  infinite.yaw = std::numeric_limits<double>::infinity();
  const Pose2 wrong{0.0, 1.0, 0.0};
  for (const auto& [camera, verdict] : {
           std::pair{seen(odom_at(now_), -period_ns - 1), Verdict::future},
           {taken_at(Limits::max()), Verdict::future},
           {seen_at({}, 201 * millisecond), Verdict::too_old},
           {taken_at(Limits::min()), Verdict::too_old},
           {seen_at({}, 199 * millisecond), Verdict::fused},
           {infinite, Verdict::non_finite},
           {seen_at({}, 40 * millisecond), Verdict::fused},
           {seen_at({}, 40 * millisecond), Verdict::duplicate},
           {seen_at({}, 50 * millisecond), Verdict::too_old},  // older than the last fused pose
           {seen_at(wrong, 30 * millisecond), Verdict::gated},
           {seen_at(wrong, 30 * millisecond), Verdict::duplicate},
       })
    EXPECT_EQ(take(camera), verdict) << now_ - camera.capture_ns;
}

TEST_F(PoseAnchorTest, PoseFromBeforeTheHistoryIsTooOld) {
  drive(4);
  EXPECT_EQ(take(seen_at({}, 21 * millisecond)), Verdict::too_old);
  FilterSettings high_latency;
  high_latency.camera_max_latency_s = 10.0;
  begin(high_latency);
  drive(1000);
  const std::int64_t oldest = (static_cast<std::int64_t>(PoseAnchor::ring_ticks) - 1) * period_ns;
  EXPECT_EQ(take(seen_at({}, oldest + 1)), Verdict::too_old);
  EXPECT_EQ(take(seen_at({}, oldest)), Verdict::fused);
}

TEST_F(PoseAnchorTest, ExtremeSigmasLeaveAPositiveDefiniteCovariance) {
  drive(100);
  EXPECT_EQ(take(seen_at({}, 40 * millisecond, 1e-200)), Verdict::fused);
  drive(10);
  EXPECT_EQ(take(seen(anchor_.map(), 0, 1e200)), Verdict::fused);
  EXPECT_TRUE(is_finite(anchor_.covariance()));
}

TEST_F(PoseAnchorTest, SettingAPoseWhileDrivingIsAJump) {
  drive(100);
  const Pose2 before = anchor_.map();
  const Pose2 odom = anchor_.odom();
  anchor_.set_pose({7.0, 8.0, 0.0});
  EXPECT_THAT(anchor_.map(), PoseNear(Pose2{7.0, 8.0, 0.0}, 1e-12));
  EXPECT_THAT(anchor_.odom(), PoseNear(odom, 0.0));
  EXPECT_EQ(anchor_.reset_count(), 2U);
  EXPECT_NEAR(anchor_.last_jump().x, 7.0 - before.x, 1e-12);
  EXPECT_NEAR(std::sqrt(anchor_.covariance()[0]), 0.05, 1e-9);
}

}  // namespace
}  // namespace odomd::estimator::testing::pose_anchor_test
