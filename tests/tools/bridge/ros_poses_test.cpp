// Poses converted to ROS messages and back.
#include <limits>
#include <numbers>

#include "tests/gtest.hpp"
#include "tools/bridge/odometry.hpp"
#include "tools/bridge/pose_intake.hpp"

namespace odomd::tools::ros_poses_test {
namespace {

BridgeSample sample() {
  BridgeSample sample;
  odom_pose& pose = sample.pose;
  pose.x = 10.0;
  pose.y = -4.0;
  pose.yaw = 2.0;
  pose.odom_x = 9.0;
  pose.odom_y = -5.5;
  pose.odom_yaw = 2.0 - std::numbers::pi / 2.0;
  pose.vx = 3.0;
  pose.vy = -0.25;
  pose.yaw_rate = 0.5;
  const double covariance[]{0.04, 0.01, 0.002, 0.09, -0.003, 0.0016};
  std::copy(std::begin(covariance), std::end(covariance), pose.covariance);
  for (int i = 0; i < 15; ++i) sample.details.velocity_covariance[i] = 100.0 + i;
  return sample;
}

/// The elements (x, x), (x, y), (x, yaw), (y, y), (y, yaw) and (yaw, yaw); no other is known.
std::array<double, 6> planar(const Covariance6& P) {
  const auto is_observed = [](std::size_t i) { return i < 2 || i == 5; };
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 6; ++j) {
      EXPECT_EQ(P[6 * i + j], P[6 * j + i]);
      if (!is_observed(i) || !is_observed(j)) {
        EXPECT_EQ(P[6 * i + j], i == j ? 1e6 : 0.0) << i << ',' << j;
      }
    }
  return {P[0], P[1], P[5], P[7], P[11], P[35]};
}

TEST(Odometry, InTheMapHasItsCovariancesWhereRosExpectsThem) {
  const Odometry odometry = odometry_of(sample(), PoseFrame::map);
  EXPECT_EQ(odometry.pose.x, 10.0);
  EXPECT_EQ(odometry.pose.yaw, 2.0);
  EXPECT_EQ(odometry.vy, -0.25);
  EXPECT_THAT(planar(odometry.pose_covariance),
              ElementsAre(0.04, 0.01, 0.002, 0.09, -0.003, 0.0016));
  EXPECT_THAT(planar(odometry.twist_covariance),
              ElementsAre(109.0, 110.0, 111.0, 112.0, 113.0, 114.0));
}

TEST(Odometry, InTheOdometryFrameHasItsCovarianceAlongTheAxesOfTheFrame) {
  // The odometry frame is turned by +90 degrees in the map: its x axis is the map's y axis, and its
  // y axis is the map's -x axis.
  const Odometry odometry = odometry_of(sample(), PoseFrame::odom);
  EXPECT_EQ(odometry.pose.x, 9.0);
  EXPECT_EQ(odometry.pose.y, -5.5);
  EXPECT_THAT(
      planar(odometry.pose_covariance),
      testing::Pointwise(testing::DoubleNear(1e-15), {0.09, -0.01, -0.003, 0.04, -0.002, 0.0016}));
}

TEST(Odometry, QuaternionOfAnUnwrappedYawHasOneSign) {
  const double turn = 2.0 * std::numbers::pi;
  const PlanarQuaternion once = quaternion_of(0.7);
  const PlanarQuaternion later = quaternion_of(0.7 + 5.0 * turn);
  EXPECT_NEAR(once.z, std::sin(0.35), 1e-15);
  EXPECT_NEAR(once.w, std::cos(0.35), 1e-15);
  EXPECT_NEAR(later.z, once.z, 1e-12);
  EXPECT_NEAR(later.w, once.w, 1e-12);
  EXPECT_NEAR(std::hypot(later.z, later.w), 1.0, 1e-15);
}

constexpr double inf = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::int64_t now_ns = 1'700'000'000'000'000'000;
constexpr std::int64_t ms = 1'000'000;

const PoseInput expected{"/pose", "map", "base_link", {0.01, 0.02, 0.03}, "/nowhere/camera.sock"};

template <typename Change>
RosPose changed(const Change& change) {
  RosPose pose{now_ns - 40 * ms, "map", {}, 1.5, -2.5, {0, 0, std::sin(0.4), std::cos(0.4)}, {}};
  change(pose);
  return pose;
}

TEST(CheckPose, RefusesWithReasonAndFix) {
  const struct {
    void (*change)(RosPose&);
    const char* refusal;
    const char* says;
  } cases[]{
      {[](RosPose& p) { p.frame = "odom"; }, "frame", R"("odom", not "map")"},
      {[](RosPose& p) { p.frame = "/map"; }, "frame", "--pose-frame"},
      {[](RosPose& p) { p.frame = ""; }, "frame", R"(is "", not)"},
      {[](RosPose& p) { p.child_frame = "lidar"; }, "child_frame", "--pose-child-frame"},
      {[](RosPose& p) { p.stamp_ns = 0; }, "no_stamp", "its stamp is 0"},
      {[](RosPose& p) { p.stamp_ns = now_ns + 6 * ms; }, "future", "0.006 s ahead"},
      {[](RosPose& p) { p.stamp_ns = now_ns - 10'001 * ms; }, "old", "10.001 s old"},
      {[](RosPose& p) { p.stamp_ns = 12'000 * ms; }, "old", "use_sim_time"},
      {[](RosPose& p) { p.x = nan; }, "not_finite", "not finite"},
      {[](RosPose& p) { p.rotation[1] = nan; }, "not_finite", "not finite"},
      {[](RosPose& p) { p.rotation = {}; }, "rotation", "length 0.000"},
      {[](RosPose& p) { p.rotation[3] += 0.05; }, "rotation", "length 1.0"},
      {[](RosPose& p) { std::swap(p.rotation[0], p.rotation[3]); }, "tilted", "134 degrees"},
      // near the bounds
      {[](RosPose& p) { p.stamp_ns = now_ns + 5 * ms; }, "", ""},
      {[](RosPose& p) { p.stamp_ns = now_ns - 9'999 * ms; }, "", ""},
      {[](RosPose& p) { p.child_frame = "base_link"; }, "", ""},
      {[](RosPose& p) { std::swap(p.rotation[0], p.rotation[2]); }, "", ""},
  };
  for (const auto& [change, refusal, says] : cases) {
    const CheckedPose pose = check_pose(changed(change), expected, now_ns);
    EXPECT_EQ(pose.refusal, refusal) << says << pose.problem;
    EXPECT_THAT(pose.problem, HasSubstr(says));
  }
}

TEST(CheckPose, SigmasAreTheRootsOfTheVariancesButAtLeastTheConfiguredOnes) {
  const struct {
    double x, y, yaw;
    std::array<double, 3> sigma;
    bool lacks;
  } cases[]{
      {0.04, 0.09, 0.25, {0.2, 0.3, 0.5}, false}, {1e-6, 0.09, 1e-9, {0.01, 0.3, 0.03}, false},
      {0.0, 0.0, 0.0, {0.01, 0.02, 0.03}, true},  {0.04, -1.0, 0.25, {0.2, 0.02, 0.5}, true},
      {nan, 0.09, inf, {0.01, 0.3, 0.03}, true},
  };
  for (const auto& [x, y, yaw, sigma, lacks] : cases) {
    Covariance6 covariance{};
    covariance[0] = x;
    covariance[7] = y;
    covariance[35] = yaw;
    const RosPose pose = changed([&](RosPose& p) { p.covariance = covariance.data(); });
    const CheckedPose checked = check_pose(pose, expected, now_ns);
    EXPECT_EQ(checked.lacks_sigma, lacks) << x;
    EXPECT_THAT((std::array{checked.pose.sigma_x, checked.pose.sigma_y, checked.pose.sigma_yaw}),
                ElementsAre(sigma[0], sigma[1], sigma[2]));
  }
}

TEST(PoseIntake, LimitsTheNumberOfMessages) {
  PoseIntake intake(expected);
  for (int i = 0; i < 1000; ++i) intake.note(std::to_string(i), "another frame");
  EXPECT_LE(intake.take_messages().size(), 50U);
}

}  // namespace
}  // namespace odomd::tools::ros_poses_test
