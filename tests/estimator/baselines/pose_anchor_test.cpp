// Late camera poses with a known odometry: which ones re-anchor, and which are rejected.
#include "estimator/baselines/pose_anchor.hpp"

#include <limits>

#include "tests/gtest.hpp"

namespace odomd::estimator::pose_anchor_test {
namespace {

constexpr std::int64_t period_ns = 5'000'000;
constexpr std::int64_t start_ns = 1'000'000'000;
constexpr std::int64_t millisecond = 1'000'000;
constexpr double infinity = std::numeric_limits<double>::infinity();

/// A car that drives a circle of 0.5 m radius at 1 m/s in its odometry frame.
class PoseAnchorTest : public ::testing::Test {
 protected:
  static constexpr BodyVelocity velocity{1.0, 0.05, 2.0};
  static constexpr Symmetric3 velocity_covariance{4e-4, 0.0, 0.0, 1e-4, 0.0, 1e-3};

  void begin(const FilterSettings& settings = {}, const Pose2& pose = {}) {
    anchor_ = PoseAnchor{settings};
    if (!settings.initialise_from_camera) {
      anchor_.set_pose(pose);
    }
    now_ = start_ns;
  }

  void drive(int ticks, double noise_factor = 1.0) {
    for (int i = 0; i < ticks; ++i) {
      now_ += period_ns;
      anchor_.extend(now_, {.velocity = velocity,
                            .covariance = packed(noise_factor * unpacked(velocity_covariance)),
                            .mean = velocity,
                            .way = moved({}, velocity, 0.005)});
    }
  }

  /// The odometry pose at a time, driven from the pose `origin` at the start.
  static Pose2 odom_at(std::int64_t time_ns, const Pose2& origin = {}) {
    return moved(origin, velocity, static_cast<double>(time_ns - start_ns) * 1e-9);
  }

  /// A camera pose captured `latency_ns` before now, that sees the car at `map`.
  [[nodiscard]] CameraPose seen(const Pose2& map, std::int64_t latency_ns,
                                double sigma = 0.01) const {
    return {now_ - latency_ns, now_, map.x, map.y, map.yaw, sigma, sigma, sigma};
  }

  Verdict take(const CameraPose& camera) { return anchor_.take(camera, now_ + period_ns, now_); }

  static void expect_near(const Pose2& a, const Pose2& b, double tolerance) {
    EXPECT_NEAR(a.x, b.x, tolerance);
    EXPECT_NEAR(a.y, b.y, tolerance);
    EXPECT_NEAR(a.yaw, b.yaw, tolerance);
  }

  void expect_positive_definite() const { EXPECT_TRUE(is_positive_definite(anchor_.covariance())); }

  PoseAnchor anchor_{FilterSettings{}};
  std::int64_t now_ = start_ns;
};

TEST_F(PoseAnchorTest, MapIsTheOdometryUntilACameraSpeaks) {
  begin({}, {1.0, 2.0, 0.5});
  drive(100);
  EXPECT_EQ(anchor_.map().x, anchor_.odom().x);
  EXPECT_EQ(anchor_.map().y, anchor_.odom().y);
  EXPECT_EQ(anchor_.map().yaw, anchor_.odom().yaw);
  EXPECT_EQ(anchor_.reset_count(), 1U);
  EXPECT_EQ(anchor_.last_jump().x, 0.0);
}

TEST_F(PoseAnchorTest, LatePoseReAnchorsWhereItWasTaken) {
  // The true map frame is elsewhere; the pose is 41.3 ms late, between two ticks.
  const Pose2 true_anchor{0.02, -0.03, 0.01};
  begin();
  drive(100);
  const std::int64_t latency = 41'300'000;
  const Pose2 before = anchor_.map();
  ASSERT_EQ(take(seen(compose(true_anchor, odom_at(now_ - latency)), latency)), Verdict::fused);
  expect_near(anchor_.map(), compose(true_anchor, odom_at(now_)), 1e-9);
  expect_near(anchor_.odom(), odom_at(now_), 1e-12);
  EXPECT_EQ(anchor_.reset_count(), 2U);
  EXPECT_EQ(anchor_.camera_ns(), now_ - latency);
  expect_near(
      anchor_.last_jump(),
      {anchor_.map().x - before.x, anchor_.map().y - before.y, anchor_.map().yaw - before.yaw},
      0.0);
  EXPECT_LT(anchor_.test_ratio(), 1.0);
}

TEST_F(PoseAnchorTest, PoseTakenAfterTheTickReAnchorsToo) {
  const Pose2 true_anchor{0.02, -0.03, 0.01};
  begin();
  drive(100);
  const CameraPose camera =
      seen(compose(true_anchor, odom_at(now_ + 2 * millisecond)), -2 * millisecond);
  ASSERT_EQ(take(camera), Verdict::fused);
  expect_near(anchor_.map(), compose(true_anchor, odom_at(now_)), 1e-9);
  expect_positive_definite();
}

TEST_F(PoseAnchorTest, YawStaysContinuousWhateverTurnTheCameraCounts) {
  begin();
  drive(2000);  // 20 rad
  const double yaw = anchor_.map().yaw;
  ASSERT_GT(yaw, 19.0);
  Pose2 map = odom_at(now_ - 20 * millisecond);
  map.yaw = wrap_angle(map.yaw + 0.01);
  ASSERT_EQ(take(seen(map, 20 * millisecond)), Verdict::fused);
  EXPECT_NEAR(anchor_.map().yaw, yaw + 0.01, 1e-9);
}

TEST_F(PoseAnchorTest, CovarianceIsTheCamerasGrownSinceTheCapture) {
  begin();
  drive(100);
  const double sigma = 0.004;
  ASSERT_EQ(take(seen(odom_at(now_ - 40 * millisecond), 40 * millisecond, sigma)), Verdict::fused);
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
  expect_positive_definite();
}

TEST_F(PoseAnchorTest, CovarianceGrowsOpenLoopAndStaysPositiveDefiniteAndBounded) {
  FilterSettings settings;
  begin(settings);
  const Symmetric3 first = anchor_.covariance();
  drive(2000);
  const Symmetric3 later = anchor_.covariance();
  EXPECT_GT(later[0], first[0]);
  EXPECT_GT(later[5], first[5]);
  // 1.4 hours.
  for (int i = 0; i < 1000; ++i) {
    drive(1000);
    ASSERT_TRUE(is_positive_definite(anchor_.covariance())) << i;
    ASSERT_TRUE(is_finite(anchor_.covariance()));
  }
  EXPECT_LE(anchor_.covariance()[0], 1e6);
  EXPECT_LE(anchor_.covariance()[5], 9.87);
}

TEST_F(PoseAnchorTest, ImplausiblePoseIsGatedAndChangesNothing) {
  begin();
  drive(100);
  const Pose2 before = anchor_.map();
  Pose2 map = odom_at(now_ - 40 * millisecond);
  map.x += 0.5;
  EXPECT_EQ(take(seen(map, 40 * millisecond)), Verdict::gated);
  EXPECT_GT(anchor_.test_ratio(), 1.0);
  expect_near(anchor_.map(), before, 0.0);
  EXPECT_EQ(anchor_.reset_count(), 1U);
  EXPECT_EQ(anchor_.camera_ns(), 0);
}

TEST_F(PoseAnchorTest, GateIsAtTheChiSquareOfTheSettings) {
  // ν along x alone: ν² / (P + R) against 16.27. A tight yaw keeps P diagonal.
  begin();
  const double sigma = 0.12;  // S = 0.05² + 0.12² = 0.13²
  const auto off_by = [&](double edges) {
    drive(1);
    Pose2 map = anchor_.map();
    map.x += edges * std::sqrt(16.27) * 0.13;
    return take(seen(map, 0, sigma));
  };
  EXPECT_EQ(off_by(1.01), Verdict::gated);
  EXPECT_EQ(off_by(0.99), Verdict::fused);
  EXPECT_NEAR(anchor_.test_ratio(), 0.98, 0.01);
}

TEST_F(PoseAnchorTest, ConsistentRejectedPosesAreAcceptedAfterTen) {
  const Pose2 true_anchor{3.0, -1.0, 1.0};
  begin();
  drive(50);
  for (int i = 1; i <= PoseAnchor::rejections_to_accept; ++i) {
    drive(7);
    const Pose2 map = compose(true_anchor, odom_at(now_ - 40 * millisecond));
    const Verdict expected = i < PoseAnchor::rejections_to_accept ? Verdict::gated : Verdict::fused;
    ASSERT_EQ(take(seen(map, 40 * millisecond)), expected) << i;
  }
  expect_near(anchor_.map(), compose(true_anchor, odom_at(now_)), 1e-5);
  EXPECT_EQ(anchor_.reset_count(), 2U);
  EXPECT_GT(anchor_.test_ratio(), 1.0);
}

TEST_F(PoseAnchorTest, RejectedPosesThatContradictEachOtherAreNeverAccepted) {
  begin();
  drive(50);
  for (int i = 0; i < 100; ++i) {
    drive(7);
    const double side = i % 2 == 0 ? 4.0 : -4.0;
    ASSERT_EQ(take(seen({side, side, 0.0}, 40 * millisecond)), Verdict::gated) << i;
  }
}

TEST_F(PoseAnchorTest, RunOfRejectedBeginsAnewWithOneThatDoesNotAgree) {
  begin();
  drive(50);
  for (int i = 1; i <= 2 * PoseAnchor::rejections_to_accept; ++i) {
    drive(7);
    // From the tenth pose on the camera sees the car 2 m farther ahead.
    const double further = i < PoseAnchor::rejections_to_accept ? 0.0 : 2.0;
    const Pose2 map = compose({3.0 + further, -1.0, 1.0}, odom_at(now_));
    const bool accepted = i == 2 * PoseAnchor::rejections_to_accept - 1;
    ASSERT_EQ(take(seen(map, 0)), accepted ? Verdict::fused : Verdict::gated) << i;
    if (accepted) {
      break;
    }
  }
  EXPECT_EQ(anchor_.reset_count(), 2U);
}

TEST_F(PoseAnchorTest, RejectedPoseFromBeforeTheOthersDoesNotCount) {
  begin();
  drive(50);
  for (int i = 1; i <= 2 * PoseAnchor::rejections_to_accept; ++i) {
    drive(7);
    // Every second picture was taken before the one that arrived ahead of it.
    const std::int64_t latency = i % 2 == 0 ? 40 * millisecond : 0;
    const Pose2 map = compose({3.0, -1.0, 1.0}, odom_at(now_ - latency));
    ASSERT_EQ(take(seen(map, latency)), Verdict::gated) << i;
  }
}

TEST_F(PoseAnchorTest, RunOfRejectedEndsAtAPause) {
  const Pose2 true_anchor{3.0, -1.0, 1.0};
  begin();
  drive(50);
  for (int i = 0; i < 30; ++i) {
    drive(i % 9 == 8 ? 101 : 7);
    const Pose2 map = compose(true_anchor, odom_at(now_ - 40 * millisecond));
    ASSERT_EQ(take(seen(map, 40 * millisecond)), Verdict::gated) << i;
  }
}

TEST_F(PoseAnchorTest, CameraIsAcceptedWhileTheWheelsSpin) {
  // The car moves at a fifth of the measured speed, and turns half as fast.
  begin();
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
    if (i > 28) {
      worst = std::max(worst, std::hypot(anchor_.map().x - truth.x, anchor_.map().y - truth.y));
    }
  }
  EXPECT_LT(rejected, 280 / 4);
  // The error grows at most for the length of a run of rejected poses.
  EXPECT_LT(worst, 0.8 * 0.035 * (PoseAnchor::rejections_to_accept + 4));
}

TEST_F(PoseAnchorTest, DistrustShowsInTheCovarianceAndPasses) {
  const Pose2 true_anchor{3.0, -1.0, 1.0};
  begin();
  drive(50);
  for (int i = 0; i < PoseAnchor::rejections_to_accept; ++i) {
    drive(7);
    take(seen(compose(true_anchor, odom_at(now_)), 0));
  }
  ASSERT_EQ(anchor_.reset_count(), 2U);
  const auto sigma_after_a_gap = [&] {
    drive(7);
    EXPECT_EQ(take(seen(compose(true_anchor, odom_at(now_)), 0)), Verdict::fused);
    drive(7);
    expect_positive_definite();
    return std::sqrt(anchor_.covariance()[0]);
  };
  // σ: 7 ticks at a speed error of 0.5 m/s plus half of 1 m/s, and the camera's 10 mm.
  EXPECT_NEAR(sigma_after_a_gap(), std::hypot(0.010, 7 * 0.005 * 1.0), 0.005);
  drive(400);
  EXPECT_NEAR(sigma_after_a_gap(), 0.010, 0.001);
}

TEST_F(PoseAnchorTest, OneGoodPoseEndsTheRunOfRejected) {
  const Pose2 wrong{3.0, -1.0, 1.0};
  begin();
  drive(50);
  for (int i = 0; i < 30; ++i) {
    drive(7);
    const Pose2 truth = odom_at(now_ - 40 * millisecond);
    const bool good = i % 9 == 8;
    ASSERT_EQ(take(seen(good ? truth : compose(wrong, truth), 40 * millisecond)),
              good ? Verdict::fused : Verdict::gated)
        << i;
  }
}

TEST_F(PoseAnchorTest, PoseIsAcceptedAgainOnceTheUncertaintyHasGrown) {
  begin();
  drive(50);
  Pose2 off = odom_at(now_ - 40 * millisecond);
  off.x += 0.35;
  EXPECT_EQ(take(seen(off, 40 * millisecond)), Verdict::gated);
  drive(4000, 1000.0);
  off = odom_at(now_ - 40 * millisecond);
  off.x += 0.35;
  EXPECT_EQ(take(seen(off, 40 * millisecond)), Verdict::fused);
}

TEST_F(PoseAnchorTest, DuplicateCaptureIsRefused) {
  begin();
  drive(100);
  const CameraPose camera = seen(odom_at(now_ - 40 * millisecond), 40 * millisecond);
  EXPECT_EQ(take(camera), Verdict::fused);
  EXPECT_EQ(take(camera), Verdict::duplicate);
  Pose2 wrong = odom_at(now_ - 30 * millisecond);
  wrong.y += 1.0;
  const CameraPose gated = seen(wrong, 30 * millisecond);
  EXPECT_EQ(take(gated), Verdict::gated);
  EXPECT_EQ(take(gated), Verdict::duplicate);
}

TEST_F(PoseAnchorTest, PoseAheadOfTheLimitIsFromTheFuture) {
  begin();
  drive(100);
  EXPECT_EQ(take(seen(odom_at(now_), -period_ns - 1)), Verdict::future);
  CameraPose camera = seen(odom_at(now_), 0);
  camera.capture_ns = std::numeric_limits<std::int64_t>::max();
  EXPECT_EQ(take(camera), Verdict::future);
}

TEST_F(PoseAnchorTest, PoseBeyondTheLatencyIsTooOld) {
  begin();
  drive(400);
  EXPECT_EQ(take(seen(odom_at(now_ - 201 * millisecond), 201 * millisecond)), Verdict::too_old);
  EXPECT_EQ(take(seen(odom_at(now_ - 199 * millisecond), 199 * millisecond)), Verdict::fused);
  CameraPose camera = seen(odom_at(now_), 0);
  camera.capture_ns = std::numeric_limits<std::int64_t>::min();
  EXPECT_EQ(take(camera), Verdict::too_old);
}

TEST_F(PoseAnchorTest, PoseFromBeforeTheHistoryIsTooOld) {
  begin();
  drive(4);
  EXPECT_EQ(take(seen(odom_at(now_ - 21 * millisecond), 21 * millisecond)), Verdict::too_old);
  FilterSettings high_latency;
  high_latency.camera_max_latency_s = 10.0;
  begin(high_latency);
  drive(1000);
  const std::int64_t oldest = (static_cast<std::int64_t>(PoseAnchor::ring_ticks) - 1) * period_ns;
  EXPECT_EQ(take(seen(odom_at(now_ - oldest - 1), oldest + 1)), Verdict::too_old);
  EXPECT_EQ(take(seen(odom_at(now_ - oldest), oldest)), Verdict::fused);
  expect_positive_definite();
}

TEST_F(PoseAnchorTest, PoseTakenBeforeTheLastFusedIsTooOld) {
  begin();
  drive(100);
  EXPECT_EQ(take(seen(odom_at(now_ - 30 * millisecond), 30 * millisecond)), Verdict::fused);
  EXPECT_EQ(take(seen(odom_at(now_ - 40 * millisecond), 40 * millisecond)), Verdict::too_old);
}

TEST_F(PoseAnchorTest, NonFiniteNumbersAndSigmasAreRefused) {
  begin();
  drive(100);
  const CameraPose good = seen(odom_at(now_ - 40 * millisecond), 40 * millisecond);
  for (double CameraPose::*field :
       {&CameraPose::x, &CameraPose::y, &CameraPose::yaw, &CameraPose::sigma_x,
        &CameraPose::sigma_y, &CameraPose::sigma_yaw}) {
    for (const double value : {infinity, -infinity, std::nan("")}) {
      CameraPose camera = good;
      camera.*field = value;
      EXPECT_EQ(take(camera), Verdict::non_finite);
    }
  }
  for (double CameraPose::*field :
       {&CameraPose::sigma_x, &CameraPose::sigma_y, &CameraPose::sigma_yaw}) {
    for (const double value : {0.0, -0.1}) {
      CameraPose camera = good;
      camera.*field = value;
      EXPECT_EQ(take(camera), Verdict::non_finite);
    }
  }
  EXPECT_EQ(take(good), Verdict::fused);
}

TEST_F(PoseAnchorTest, SillySigmasLeaveAPositiveDefiniteCovariance) {
  begin();
  drive(100);
  EXPECT_EQ(take(seen(odom_at(now_ - 40 * millisecond), 40 * millisecond, 1e-200)), Verdict::fused);
  expect_positive_definite();
  drive(10);
  EXPECT_EQ(take(seen(anchor_.map(), 0, 1e200)), Verdict::fused);
  expect_positive_definite();
  EXPECT_TRUE(is_finite(anchor_.covariance()));
}

TEST_F(PoseAnchorTest, AbsurdCoordinatesAreGatedEvenWhenInitialising) {
  FilterSettings settings;
  settings.initialise_from_camera = true;
  begin(settings);
  drive(100);
  EXPECT_EQ(take(seen({1e300, 0.0, 0.0}, 40 * millisecond)), Verdict::gated);
  EXPECT_FALSE(anchor_.initialised());
}

TEST_F(PoseAnchorTest, FirstCameraPoseInitialises) {
  FilterSettings settings;
  settings.initialise_from_camera = true;
  begin(settings);
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
  FilterSettings settings;
  settings.initialise_from_camera = true;
  begin(settings);
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
  FilterSettings settings;
  settings.initialise_from_camera = true;
  anchor_ = PoseAnchor{settings};
  now_ = start_ns;
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
  FilterSettings settings;
  settings.initialise_from_camera = true;
  anchor_ = PoseAnchor{settings};
  const Pose2 map{5.0, 6.0, 2.0};
  anchor_.resume({.map = map, .covariance = {1e-2, 0.0, 0.0, 1e-2, 0.0, 1e-2}, .reset_count = 3});
  now_ = start_ns;
  EXPECT_EQ(take(seen({1.0, 1.0, 1.0}, 40 * millisecond)), Verdict::too_old);
  expect_near(anchor_.map(), map, 1e-12);
}

TEST_F(PoseAnchorTest, CameraDoesNotInitialiseUnlessItMay) {
  anchor_ = PoseAnchor{FilterSettings{}};
  drive(100);
  EXPECT_EQ(take(seen({1.0, 1.0, 1.0}, 40 * millisecond)), Verdict::source_off);
  EXPECT_FALSE(anchor_.initialised());
}

TEST_F(PoseAnchorTest, SettingAPoseOnTheWayIsAJump) {
  begin();
  drive(100);
  const Pose2 before = anchor_.map();
  const Pose2 odom = anchor_.odom();
  anchor_.set_pose({7.0, 8.0, 0.0});
  expect_near(anchor_.map(), {7.0, 8.0, 0.0}, 1e-12);
  expect_near(anchor_.odom(), odom, 0.0);
  EXPECT_EQ(anchor_.reset_count(), 2U);
  EXPECT_NEAR(anchor_.last_jump().x, 7.0 - before.x, 1e-12);
  EXPECT_NEAR(std::sqrt(anchor_.covariance()[0]), 0.05, 1e-9);
}

TEST_F(PoseAnchorTest, ReAnchoringManyTimesKeepsTheOdometry) {
  begin();
  std::vector<Pose2> anchors;
  for (int i = 0; i < 200; ++i) {
    drive(7);
    const Pose2 small{0.01 * std::sin(i), 0.01 * std::cos(3.0 * i), 0.005 * std::sin(2.0 * i)};
    const Pose2 map = compose(small, odom_at(now_ - 35 * millisecond));
    ASSERT_EQ(take(seen(map, 35 * millisecond)), Verdict::fused);
    expect_near(anchor_.map(), compose(small, odom_at(now_)), 1e-5);
  }
  expect_near(anchor_.odom(), odom_at(now_), 1e-11);
}

}  // namespace
}  // namespace odomd::estimator::pose_anchor_test
