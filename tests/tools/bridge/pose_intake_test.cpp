#include "tools/bridge/pose_intake.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>

#include "tools/bridge/odometry.hpp"

namespace odomd::tools::pose_intake_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

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

TEST(CheckPose, SigmasAreTheRootsOfTheVariancesButNeverLessThanTheFloor) {
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

TEST(PoseIntake, HasNoEndlessListOfMessages) {
  PoseIntake intake(expected);
  for (int i = 0; i < 1000; ++i) intake.note(std::to_string(i), "another frame");
  EXPECT_LE(intake.take_messages().size(), 50U);
}

}  // namespace
}  // namespace odomd::tools::pose_intake_test
