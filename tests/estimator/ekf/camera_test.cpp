// The camera's gate and update, and the recovery of a filter that disagrees with it.
#include <Eigen/LU>
#include <numbers>
#include <random>

#include "estimator/common/pose.hpp"
#include "estimator/ekf/take.hpp"
#include "estimator/ekf/update.hpp"
#include "tests/estimator/drive.hpp"
#include "tests/estimator/ekf/states.hpp"

namespace odomd::estimator::full::testing::camera_test {
namespace {

using estimator::testing::millisecond;
using estimator::testing::PoseNear;

constexpr std::int64_t between_poses_ns = 36 * millisecond;

State located(const Pose2& pose = {}) {
  State state;
  state.time_ns = 1'000 * millisecond;
  state.located = true;
  state.mean[at::v_x] = 1.0;
  state.mean.head<3>() << pose.x, pose.y, pose.yaw;
  state.covariance = some_covariance(1e-3);
  state.slow.covariance = some_covariance<SlowMatrix>(1e-3);
  return state;
}

Sample seen(std::int64_t time_ns, const Pose2& pose, double sigma = 0.01) {
  return {.time_ns = time_ns,
          .source = Source::camera,
          .value = {pose.x, pose.y, wrap_angle(pose.yaw)},
          .sigma = {sigma, sigma, sigma}};
}

TEST(FullCamera, FirstPoseLocatesIfAllowed) {
  State state;
  state.covariance = some_covariance();
  const Judgement refused =
      take_camera(CarModel{}, {.locates = false}, state, {}, seen(1, {1.0, 2.0, 0.5}));
  EXPECT_EQ(refused.verdict, Verdict::source_off);
  EXPECT_EQ(refused.degrees, 0);
  EXPECT_FALSE(state.located);
  const Judgement first = take_camera(CarModel{}, {}, state, {}, seen(1, {1.0, 2.0, 0.5}, 0.02));
  EXPECT_EQ(first.verdict, Verdict::fused);
  EXPECT_EQ(first.degrees, 0);  // there is nothing to compare it with
  EXPECT_TRUE(state.located);
  EXPECT_THAT(state.pose(), PoseNear({1.0, 2.0, 0.5}, 0.0));
  EXPECT_NEAR(state.variance(at::yaw), 4e-4, 1e-18);
  EXPECT_TRUE(is_covariance(state.covariance));
  EXPECT_EQ(state.resets, 0U);
}

TEST(FullCamera, PoseIsJudgedAsAWholeWithBothNoises) {
  State before = located({1.0, 2.0, 0.3});
  before.slow.sensitivity(at::x, slow::wheel_scale) = 1.5;
  const Pose2 pose{1.05, 1.9, 0.36};
  State state = before;
  const Judgement judgement = take_camera(CarModel{}, {}, state, {}, seen(1, pose, 0.02));
  const Eigen::Vector3d nu(0.05, -0.1, 0.06);
  const Eigen::Matrix3d S =
      covariance_of_motion(before).topLeftCorner<3, 3>() + 4e-4 * Eigen::Matrix3d::Identity();
  EXPECT_EQ(judgement.degrees, 3);
  EXPECT_LT(largest(Eigen::Vector3d(judgement.innovation.data()) - nu), 1e-14);
  EXPECT_NEAR(judgement.squared_ratio, nu.dot(S.inverse() * nu), 1e-9);
  EXPECT_NEAR(judgement.test_ratio, judgement.squared_ratio / CameraGate{}.gate, 1e-12);
  EXPECT_EQ(state.camera_test_ratio, judgement.test_ratio);

  // The gate is at its configured limit.
  const double just = judgement.squared_ratio;
  for (const auto& [share, verdict] : {std::pair{1.001, Verdict::fused}, {0.999, Verdict::gated}}) {
    state = before;
    EXPECT_EQ(
        take_camera(CarModel{}, {.gate = just * share}, state, {}, seen(1, pose, 0.02)).verdict,
        verdict);
  }
  EXPECT_EQ(state.mean, before.mean);
  EXPECT_EQ(state.covariance, before.covariance);
}

TEST(FullCamera, CorrectsEverythingCorrelatedWithThePose) {
  // Compares states and slow errors with one joint update by all three numbers.
  State before = located({1.0, 2.0, 0.3});
  before.slow = some_slow_errors(1e-3);
  State state = before;
  ASSERT_EQ(
      take_camera(CarModel{}, {.gate = 1e9}, state, {}, seen(1, {1.05, 1.9, 0.36}, 0.02)).verdict,
      Verdict::fused);
  const JointMatrix P = joint_covariance(before);
  const Eigen::Matrix<double, joint_size, 3> PHt = P.leftCols<3>();
  const Eigen::Matrix3d S = PHt.topRows<3>() + 4e-4 * Eigen::Matrix3d::Identity();
  const Eigen::Matrix<double, joint_size, 3> K = PHt * S.inverse();
  const auto change = (K * Eigen::Vector3d(0.05, -0.1, 0.06)).eval();
  EXPECT_LT(largest(state.mean - before.mean - change.head<at::size>()), 1e-12);
  EXPECT_LT(largest(state.slow.mean - before.slow.mean - change.tail<slow::size>()), 1e-12);
  EXPECT_LT(largest(joint_covariance(state) - (P - K * PHt.transpose())), 1e-13);
  EXPECT_TRUE(has_covariances(state));
}

TEST(FullCamera, YawStaysContinuousOverAnyNumberOfTurns) {
  for (const double turns : {-7.0, 0.0, 12.0}) {
    const double yaw = 3.1 + turns * 2.0 * std::numbers::pi;
    State state = located({0.0, 0.0, yaw});
    const Judgement judgement =
        take_camera(CarModel{}, {}, state, {}, seen(1, {0.0, 0.0, yaw + 0.06}));
    EXPECT_EQ(judgement.verdict, Verdict::fused);
    EXPECT_NEAR(judgement.innovation[2], 0.06, 1e-12);
    EXPECT_NEAR(state.mean[at::yaw], yaw, 0.1);
  }
}

/// A filter that drives along x, and a camera that sees it elsewhere. Wheels and gyro agree with
/// the filter.
struct Disagreement {
  State state = located();
  Pose2 truth;           ///< where the camera sees it at the start
  double heading = 0.0;  ///< the car's direction in the camera's frame
  double speed = 1.0;    ///< [m/s]
  std::int64_t between_ns = between_poses_ns;
  Context context;

  Judgement pose(int number, const Pose2& noise = {}) {
    constexpr int ticks_between_poses = 6;
    const double way = speed * static_cast<double>(between_ns) * 1e-9;
    for (int i = 0; i < ticks_between_poses; ++i) {
      state.time_ns += between_ns / ticks_between_poses;
      const double tremor = i % 2 == 0 ? 1e-6 : -1e-6;  // a moving sensor does not repeat its value
      for (const Source source : {Source::wheel_rear_left, Source::wheel_rear_right})
        state.integrity.add(source, state.time_ns, speed + tremor, 0.01);
      state.integrity.add(Source::yaw_rate, state.time_ns, tremor, 0.005);
      state.integrity.check({}, state.time_ns, {.camera_noise_scale = state.camera_noise_scale});
    }
    state.mean[at::x] += way * std::cos(state.mean[at::yaw]);
    state.mean[at::y] += way * std::sin(state.mean[at::yaw]);
    const double gone = way * number;
    const Sample sample =
        seen(state.time_ns, {truth.x + gone * std::cos(heading) + noise.x,
                             truth.y + gone * std::sin(heading) + noise.y, truth.yaw + noise.yaw});
    return take(context, state, sample);
  }

  /// Sends poses after the first `before` until one is accepted, but no more than `most`.
  int until_accepted(int most, int before = 0) {
    int poses = 0;
    while (state.resets == 0 && poses < most) pose(before + ++poses);
    return poses;
  }

  /// A camera that agreed for 60 poses, and now sees the car elsewhere.
  static Disagreement after_sixty(const Pose2& truth) {
    Disagreement car;
    for (int i = 1; i <= 60; ++i) EXPECT_EQ(car.pose(i).verdict, Verdict::fused) << i;
    car.truth = truth;
    return car;
  }
};

constexpr double seconds_per_pose = static_cast<double>(between_poses_ns) * 1e-9;
constexpr double longest_recovery_s = 0.3;

TEST(FullCamera, ConsistentPosesAreAcceptedInTheEnd) {
  Disagreement car{.truth = {5.0, -3.0, 0.0}};
  Judgement judgement = car.pose(1);
  int poses = 1;
  for (; judgement.verdict == Verdict::gated && poses < 50; judgement = car.pose(++poses)) {
    EXPECT_EQ(judgement.degrees, 3) << poses;
    EXPECT_EQ(car.state.resets, 0U);
    EXPECT_NEAR(car.state.mean[at::y], 0.0, 1e-12);
  }
  // The pose is forced, not fused, and only after others: a single one may be an outlier.
  EXPECT_GE(poses, 3);
  EXPECT_LT(poses * seconds_per_pose, longest_recovery_s);
  EXPECT_EQ(judgement.verdict, Verdict::forced);
  EXPECT_EQ(judgement.degrees, 0);
  EXPECT_GT(judgement.test_ratio, 1.0);
  EXPECT_NEAR(judgement.innovation[0], 5.0, 1e-12);
  EXPECT_EQ(car.state.resets, 1U);
  EXPECT_THAT(car.state.pose(), PoseNear({5.0 + 0.036 * poses, -3.0, 0.0}, 1e-3));
  EXPECT_THAT(car.state.last_jump, PoseNear({5.0, -3.0, 0.0}, 1e-3));
  EXPECT_NEAR(car.state.variance(at::x), 1e-4, 1e-6);
  EXPECT_TRUE(is_covariance(car.state.covariance));
  EXPECT_EQ(car.pose(poses + 1).verdict, Verdict::fused);
  EXPECT_EQ(car.state.resets, 1U);
}

TEST(FullCamera, ASlowCameraCorrectsTheFilterToo) {
  Disagreement car{.truth = {1.0, 0.5, 0.0}, .between_ns = 4'000 * millisecond};
  EXPECT_LT(car.until_accepted(50), 12);
}

TEST(FullCamera, AFarMapLeavesTheCovarianceItsDigits) {
  Disagreement car{.truth = {5.4e6, -3.0, 0.0}};
  car.until_accepted(50);
  EXPECT_NEAR(car.state.variance(at::x), 1e-4, 1e-6);
}

TEST(FullCamera, ACorrectionMayBeAJumpOfTheMap) {
  // The first pose initialises. A later pose that moves the state contradicts fused ones, so
  // variance for a jump of the map is published, whether the state is doubtful or not.
  Disagreement first{.truth = {5.0, -3.0, 0.0}};
  first.until_accepted(50);
  ASSERT_EQ(first.state.resets, 1U);
  EXPECT_EQ(first.state.disputed.head<2>().squaredNorm(), 0.0);
  for (const bool doubtful : {false, true}) {
    Disagreement later = Disagreement::after_sixty({0.0, -0.3, 0.0});
    int i = 61;
    for (; later.state.resets == 0 && i < 400; ++i) {
      later.state.doubtful = doubtful;
      later.pose(i);
    }
    ASSERT_EQ(later.state.resets, 1U);
    EXPECT_NEAR(later.state.disputed.head<2>().squaredNorm(), 0.25 * 0.3 * 0.3, 0.005);
    later.truth = {};  // a jump there and back cancels
    for (; later.state.resets == 1 && i < 800; ++i) later.pose(i);
    EXPECT_LT(later.state.disputed.head<2>().squaredNorm(), 0.001);
  }
}

TEST(FullCamera, ACameraThatWasDistrustedNeedsMoreEvidence) {
  const auto poses_needed = [](double evidence) {
    Disagreement car = Disagreement::after_sixty({0.0, -0.3, 0.0});
    car.state.camera_evidence = evidence;
    return car.until_accepted(340, 60);
  };
  EXPECT_GT(poses_needed(-2.0 * Tuning{}.outlier_odds), 2 * poses_needed(0.0));
}

TEST(FullCamera, SixFusedPosesInARowConfirmThePose) {
  Disagreement car;
  car.state.doubtful = true;
  for (int i = 1; i < poses_to_confirm; ++i) {
    ASSERT_EQ(car.pose(i).verdict, Verdict::fused) << i;
    EXPECT_TRUE(car.state.doubtful) << i;
  }
  ASSERT_EQ(car.pose(poses_to_confirm).verdict, Verdict::fused);
  EXPECT_FALSE(car.state.doubtful);
}

TEST(FullCamera, ACameraThatScattersMoreThanStatedIsTrustedLess) {
  // Poses as noisy as stated, and six times as noisy.
  for (const double times : {1.0, 6.0}) {
    std::mt19937 random(2);
    std::normal_distribution<double> normal(0.0, times * 0.01);
    Disagreement car;
    int gated = 0;
    for (int i = 1; i <= 800; ++i) {
      const Judgement judgement = car.pose(i, {normal(random), normal(random), normal(random)});
      gated += i > 200 && !is_taken(judgement.verdict) ? 1 : 0;
    }
    EXPECT_GT(car.state.camera_noise_scale, times > 1.0 ? 18.0 : 0.0);
    EXPECT_LT(car.state.camera_noise_scale, times > 1.0 ? 72.0 : 2.5);
    EXPECT_LT(gated, 150) << times;  // a quarter
    EXPECT_EQ(car.state.resets, 0U) << times;
  }
}

TEST(FullCamera, OutliersAreNeverAccepted) {
  Disagreement car;
  std::mt19937 random(6);
  std::uniform_real_distribution<double> anywhere(-5.0, 5.0);
  for (int i = 1; i < 500; ++i) {
    const Pose2 off{anywhere(random), 1.0 + std::abs(anywhere(random)), anywhere(random)};
    car.pose(i, off);
    EXPECT_LT(std::abs(car.state.mean[at::y]), 0.3) << i;  // effect of one outlier, wide gate
  }
  EXPECT_EQ(car.state.resets, 0U);
}

TEST(FullCamera, AFewConsistentPosesBetweenOutliersConfirmTheFilter) {
  Disagreement car;
  for (int i = 1; i < 300; ++i) {
    const bool fits = i % 3 == 0;
    car.pose(i, fits ? Pose2{} : Pose2{0.0, 2.0, 0.0});
    EXPECT_NEAR(car.state.mean[at::y], 0.0, 0.2) << i;
  }
  EXPECT_EQ(car.state.resets, 0U);
}

TEST(FullCamera, ATrackerThatHasLostTheCarIsRejected) {
  // Another car's pose, or a frozen one, contradicts the wheels.
  for (const double sigma : {0.0, 0.01}) {
    std::mt19937 random(8);
    std::normal_distribution<double> trembling(0.0, 1.0);
    for (const double speed : {0.2, 0.5, 1.0, 3.0, 6.5}) {
      Disagreement car{.truth = {5.0, -3.0, 0.0}, .speed = speed};
      int accepted = 0;
      for (int i = 1; i < 2000; ++i) {
        const auto noise = [&] { return sigma * trembling(random); };
        accepted += is_taken(car.pose(0, {noise(), noise(), noise()}).verdict) ? 1 : 0;
      }
      EXPECT_EQ(accepted, 0) << speed << ' ' << sigma;
      EXPECT_EQ(car.state.resets, 0U) << speed << ' ' << sigma;
    }
  }
}

TEST(FullCamera, AWrongHeadingIsRecoveredFrom) {
  for (const double wrong : {-3.0, -1.5, 0.8, 2.2, std::numbers::pi}) {
    Disagreement car;
    car.state.mean[at::yaw] = wrong;
    const int poses = car.until_accepted(50);
    EXPECT_LT(poses * seconds_per_pose, longest_recovery_s) << wrong;
    EXPECT_NEAR(wrap_angle(car.state.mean[at::yaw]), 0.0, 1e-3);
    EXPECT_NEAR(car.state.mean[at::x], 0.036 * poses, 2e-3);
    EXPECT_NEAR(std::abs(car.state.last_jump.yaw), std::abs(wrong), 1e-3);
  }
}

}  // namespace
}  // namespace odomd::estimator::full::testing::camera_test
