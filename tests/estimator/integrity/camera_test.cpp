// The camera's gate and update, and what becomes of a filter that disagrees with it.
#include "estimator/integrity/camera.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

#include "estimator/common/pose.hpp"
#include "estimator/ekf/update.hpp"
#include "tests/estimator/ekf/states.hpp"

namespace odomd::estimator::full::camera_test {
namespace {

constexpr std::int64_t millisecond = 1'000'000;
constexpr std::int64_t between_poses_ns = 36 * millisecond;

State located(const Pose2& pose = {}) {
  State state;
  state.time_ns = 1'000 * millisecond;
  state.located = true;
  state.mean[at::v_x] = 1.0;
  state.mean.head<3>() << pose.x, pose.y, pose.yaw;
  state.covariance = testing::some_covariance(1e-3);
  state.lasting.covariance = testing::some_covariance<LastingMatrix>(1e-3);
  return state;
}

Sample seen(std::int64_t time_ns, const Pose2& pose, double sigma = 0.01) {
  return {.time_ns = time_ns,
          .source = Source::camera,
          .value = {pose.x, pose.y, wrap_angle(pose.yaw)},
          .sigma = {sigma, sigma, sigma}};
}

TEST(FullCamera, FirstPoseLocatesWhereItMay) {
  State state;
  state.covariance = testing::some_covariance();
  const Judgement refused =
      take_camera(CarModel{}, {.locates = false}, state, seen(1, {1.0, 2.0, 0.5}));
  EXPECT_EQ(refused.verdict, Verdict::source_off);
  EXPECT_EQ(refused.degrees, 0);
  EXPECT_FALSE(state.located);
  const Judgement first = take_camera(CarModel{}, {}, state, seen(1, {1.0, 2.0, 0.5}, 0.02));
  EXPECT_EQ(first.verdict, Verdict::fused);
  EXPECT_EQ(first.degrees, 0);  // held against nothing
  EXPECT_TRUE(state.located);
  EXPECT_EQ(state.mean[at::x], 1.0);
  EXPECT_EQ(state.mean[at::y], 2.0);
  EXPECT_EQ(state.mean[at::yaw], 0.5);
  EXPECT_NEAR(state.covariance(at::yaw, at::yaw), 4e-4, 1e-18);
  EXPECT_TRUE(testing::is_covariance(state.covariance));
  EXPECT_EQ(state.resets, 0U);
}

TEST(FullCamera, IsJudgedAsAWholeByItsOwnNoiseAndTheFilters) {
  State before = located({1.0, 2.0, 0.3});
  before.lasting.sensitivity(at::x, lasting::wheel_scale) = 1.5;
  const Pose2 pose{1.05, 1.9, 0.36};
  State state = before;
  const Judgement judgement = take_camera(CarModel{}, {}, state, seen(1, pose, 0.02));
  const Eigen::Vector3d nu(0.05, -0.1, 0.06);
  const Eigen::Matrix3d S =
      covariance_of_motion(before).topLeftCorner<3, 3>() + 4e-4 * Eigen::Matrix3d::Identity();
  EXPECT_EQ(judgement.degrees, 3);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(judgement.innovation[i], nu[static_cast<Eigen::Index>(i)], 1e-14);
  }
  EXPECT_NEAR(judgement.squared_ratio, nu.dot(S.inverse() * nu), 1e-9);
  EXPECT_NEAR(judgement.test_ratio, judgement.squared_ratio / CameraGate{}.gate, 1e-12);
  EXPECT_EQ(state.camera_test_ratio, judgement.test_ratio);

  // The gate lies where it is said to lie.
  const double just = judgement.squared_ratio;
  State inside = before;
  EXPECT_EQ(take_camera(CarModel{}, {.gate = just * 1.001}, inside, seen(1, pose, 0.02)).verdict,
            Verdict::fused);
  State outside = before;
  EXPECT_EQ(take_camera(CarModel{}, {.gate = just * 0.999}, outside, seen(1, pose, 0.02)).verdict,
            Verdict::gated);
  EXPECT_EQ(outside.mean, before.mean);
  EXPECT_EQ(outside.covariance, before.covariance);
}

TEST(FullCamera, TeachesEverythingThatIsRelatedToThePose) {
  // The lasting errors too: all three numbers at once, by the textbook's filter of all states.
  State before = located({1.0, 2.0, 0.3});
  before.lasting = testing::some_lasting(1e-3);
  State state = before;
  ASSERT_EQ(take_camera(CarModel{}, {.gate = 1e9}, state, seen(1, {1.05, 1.9, 0.36}, 0.02)).verdict,
            Verdict::fused);
  constexpr int all_states = int{at::size} + int{lasting::size};
  using Joint = Eigen::Matrix<double, all_states, all_states>;
  const auto joint = [](const State& s) {
    const auto& B = s.lasting.sensitivity;
    const LastingMatrix& P_s = s.lasting.covariance;
    Joint P;
    P << s.covariance + B * P_s * B.transpose(), B * P_s, P_s * B.transpose(), P_s;
    return P;
  };
  const Joint P = joint(before);
  const Eigen::Matrix<double, all_states, 3> PHt = P.leftCols<3>();
  const Eigen::Matrix3d S = PHt.topRows<3>() + 4e-4 * Eigen::Matrix3d::Identity();
  const Eigen::Matrix<double, all_states, 3> K = PHt * S.inverse();
  const auto change = (K * Eigen::Vector3d(0.05, -0.1, 0.06)).eval();
  EXPECT_LT((state.mean - before.mean - change.head<at::size>()).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((state.lasting.mean - before.lasting.mean - change.tail<lasting::size>())
                .cwiseAbs()
                .maxCoeff(),
            1e-12);
  EXPECT_LT((joint(state) - (P - K * PHt.transpose())).cwiseAbs().maxCoeff(), 1e-13);
  EXPECT_TRUE(testing::is_covariance(state.covariance));
  EXPECT_TRUE(testing::is_covariance(state.lasting.covariance));
}

TEST(FullCamera, YawGoesOnThroughAnyNumberOfTurns) {
  for (const double turns : {-7.0, 0.0, 12.0}) {
    const double yaw = 3.1 + turns * 2.0 * std::numbers::pi;
    State state = located({0.0, 0.0, yaw});
    const Judgement judgement = take_camera(CarModel{}, {}, state, seen(1, {0.0, 0.0, yaw + 0.06}));
    EXPECT_EQ(judgement.verdict, Verdict::fused);
    EXPECT_NEAR(judgement.innovation[2], 0.06, 1e-12);
    EXPECT_NEAR(state.mean[at::yaw], yaw, 0.1);
  }
}

/// A filter that drives along x (its covariance as it is), and a camera that sees it elsewhere: one
/// pose, `number` poses after the start.
struct Disagreement {
  State state = located();
  Pose2 truth;           ///< where the camera sees it at the start
  double heading = 0.0;  ///< the way it goes there
  double speed = 1.0;    ///< [m/s]

  Judgement pose(int number, const Pose2& noise = {}) {
    const std::int64_t time_ns = state.time_ns + between_poses_ns;
    const double way = speed * static_cast<double>(between_poses_ns) * 1e-9;
    state.time_ns = time_ns;
    state.mean[at::x] += way * std::cos(state.mean[at::yaw]);
    state.mean[at::y] += way * std::sin(state.mean[at::yaw]);
    const double gone = way * number;
    return take_camera(
        CarModel{}, {}, state,
        seen(time_ns, {truth.x + gone * std::cos(heading) + noise.x,
                       truth.y + gone * std::sin(heading) + noise.y, truth.yaw + noise.yaw}));
  }
};

TEST(FullCamera, PosesThatAgreeAreBelievedInTheEnd) {
  Disagreement car{.truth = {5.0, -3.0, 0.0}};
  for (int i = 1; i < believed_rejections; ++i) {
    const Judgement rejected = car.pose(i);
    EXPECT_EQ(rejected.verdict, Verdict::gated) << i;
    EXPECT_EQ(rejected.degrees, 3);
    EXPECT_EQ(car.state.resets, 0U);
    EXPECT_NEAR(car.state.mean[at::y], 0.0, 1e-12);
  }
  // Believed against the test, not by it.
  const Judgement believed = car.pose(believed_rejections);
  EXPECT_EQ(believed.verdict, Verdict::fused);
  EXPECT_EQ(believed.degrees, 0);
  EXPECT_GT(believed.test_ratio, 1.0);
  EXPECT_NEAR(believed.innovation[0], 5.0, 1e-12);
  EXPECT_EQ(car.state.resets, 1U);
  const double gone = 0.036 * believed_rejections;
  EXPECT_NEAR(car.state.mean[at::x], 5.0 + gone, 1e-12);
  EXPECT_NEAR(car.state.mean[at::y], -3.0, 1e-12);
  EXPECT_NEAR(car.state.last_jump.x, 5.0, 1e-12);
  EXPECT_NEAR(car.state.last_jump.y, -3.0, 1e-12);
  EXPECT_NEAR(car.state.covariance(at::x, at::x), 1e-4, 1e-15);
  EXPECT_TRUE(testing::is_covariance(car.state.covariance));
  EXPECT_EQ(car.pose(believed_rejections + 1).verdict, Verdict::fused);
  EXPECT_EQ(car.state.resets, 1U);
}

TEST(FullCamera, OutliersAreNot) {
  Disagreement car;
  std::mt19937 random(6);
  std::uniform_real_distribution<double> anywhere(-5.0, 5.0);
  for (int i = 1; i < 500; ++i) {
    const Pose2 off{anywhere(random), 1.0 + std::abs(anywhere(random)), anywhere(random)};
    EXPECT_EQ(car.pose(i, off).verdict, Verdict::gated);
  }
  EXPECT_EQ(car.state.resets, 0U);
}

TEST(FullCamera, OneThatFitsBetweenThemClearsTheFilterOfSuspicion) {
  Disagreement car;
  for (int i = 1; i < 100; ++i) {
    const bool fits = i % believed_rejections == 0;
    const Pose2 off = fits ? Pose2{} : Pose2{0.0, 2.0, 0.0};
    EXPECT_EQ(car.pose(i, off).verdict, fits ? Verdict::fused : Verdict::gated) << i;
  }
  EXPECT_EQ(car.state.resets, 0U);
}

TEST(FullCamera, PosesThatAreFarApartDoNotMakeARun) {
  Disagreement car{.truth = {5.0, -3.0, 0.0}};
  for (int i = 1; i < 50; ++i) {
    car.state.time_ns += 600 * millisecond;
    EXPECT_EQ(car.pose(i).verdict, Verdict::gated);
  }
  EXPECT_EQ(car.state.resets, 0U);
}

TEST(FullCamera, ASeenCarThatDoesNotMoveWithTheFilterIsNotBelieved) {
  // Another car's pose, or a frozen one: it agrees with itself, not with the wheels.
  Disagreement car{.truth = {5.0, -3.0, 0.0}};
  car.state.mean[at::v_x] = 0.0;
  for (int i = 1; i < 200; ++i) {
    car.state.mean[at::x] += 0.2;  // at 6.5 m/s
    EXPECT_EQ(car.pose(0).verdict, Verdict::gated) << i;
  }
  EXPECT_EQ(car.state.resets, 0U);
}

TEST(FullCamera, ATrackerThatHasLostTheCarAndTremblesIsNotBelieved) {
  std::mt19937 random(8);
  std::normal_distribution<double> trembling(0.0, 0.01);
  for (const double speed : {0.2, 0.5, 1.0, 3.0}) {
    Disagreement car{.truth = {5.0, -3.0, 0.0}, .speed = speed};
    for (int i = 1; i < 2000; ++i) {
      const Pose2 noise{trembling(random), trembling(random), trembling(random)};
      EXPECT_EQ(car.pose(0, noise).verdict, Verdict::gated) << speed << " m/s, pose " << i;
    }
    EXPECT_EQ(car.state.resets, 0U);
  }
}

TEST(FullCamera, AWrongHeadingIsRecoveredFrom) {
  for (const double wrong : {-3.0, -1.5, 0.8, 2.2, std::numbers::pi}) {
    Disagreement car;
    car.state.mean[at::yaw] = wrong;
    int poses = 0;
    while (car.state.resets == 0 && poses < 50) {
      car.pose(++poses);
    }
    EXPECT_EQ(poses, believed_rejections) << wrong;
    EXPECT_NEAR(wrap_angle(car.state.mean[at::yaw]), 0.0, 1e-9);
    EXPECT_NEAR(car.state.mean[at::x], 0.036 * poses, 1e-9);
    EXPECT_NEAR(std::abs(car.state.last_jump.yaw), std::abs(wrong), 1e-9);
  }
}

}  // namespace
}  // namespace odomd::estimator::full::camera_test
