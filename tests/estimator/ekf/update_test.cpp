// Checks the update by a scalar sample against the textbook, and the filter with separate slow
// errors against the joint one.
#include "estimator/ekf/update.hpp"

#include <random>

#include "derivatives.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::full::testing::update_test {
namespace {

State somewhere() {
  State state;
  state.mean << 3.0, -2.0, 0.7, 1.5, 0.1, 0.8, 0.6, 0.1, 0.5, -0.08, 0.02, 0.01;
  state.covariance = some_covariance();
  state.slow = some_slow_errors();
  return state;
}

/// A prediction that depends on states all over the vector, and on slow errors.
Prediction something() {
  Prediction z;
  z.value = 0.3;
  z.variance = 4e-4;
  z.depends_on(at::yaw, 0.7);
  z.depends_on(at::v_y, -1.3);
  z.depends_on(at::accel_bias_x, 0.2);
  z.depends_on(at::front_angle, 2.0);
  z.by_slow[slow::gyro_bias] = 1.0;
  z.by_slow[slow::roll_gradient] = -0.4;
  return z;
}

using JointVector = Eigen::Matrix<double, joint_size, 1>;

/// x and s as one joint state, with its covariance.
struct Joint {
  JointVector mean;
  JointMatrix covariance;

  explicit Joint(const State& state) : covariance(joint_covariance(state)) {
    mean << state.mean, state.slow.mean;
  }

  /// The textbook's Kalman filter.
  void update(const Prediction& z, double measured) {
    JointVector H;
    H << stated(z), z.by_slow;
    const double S = H.dot(covariance * H) + z.variance;
    const JointVector K = covariance * H / S;
    mean += K * (measured - z.value);
    const JointMatrix left = JointMatrix::Identity() - K * H.transpose();
    covariance = left * covariance * left.transpose() + z.variance * K * K.transpose();
  }

  void propagate(const LinearStep& step) {
    mean.head<at::size>() = step.mean;
    JointMatrix F = JointMatrix::Identity();
    F.topLeftCorner<at::size, at::size>() = step.F;
    F.topRightCorner<at::size, slow::size>() = step.by_slow;
    covariance = F * covariance * F.transpose();
    covariance.topLeftCorner<at::size, at::size>() += step.noise;
    covariance.bottomRightCorner<slow::size, slow::size>() += step.slow_noise;
  }
};

Prediction any_prediction(std::mt19937& random, double value) {
  std::normal_distribution<double> normal;
  Prediction z;
  z.value = value;
  z.variance = std::pow(10.0, -4.0 + normal(random));
  for (const unsigned n : {0U, 3U, 6U})
    z.depends_on(static_cast<at::Index>(random() % 4 + n), normal(random));
  for (const unsigned n : {0U, 3U})
    z.by_slow[static_cast<Eigen::Index>(random() % 3 + n)] = normal(random);
  return z;
}

TEST(Update, InnovationMatchesTheTextbook) {
  const State state = somewhere();
  const Vector H = stated(something());
  const Innovation nu = innovation(state, something(), 0.5);
  EXPECT_NEAR(nu.value, 0.2, 1e-15);
  EXPECT_NEAR(nu.variance_of_noise, H.dot(state.covariance * H) + 4e-4, 1e-14);
  EXPECT_LT(largest(nu.covariance_with_state - state.covariance * H), 1e-15);
  const SlowVector G = state.slow.sensitivity.transpose() * H + something().by_slow;
  EXPECT_LT(largest(nu.by_slow - G), 1e-14);
  EXPECT_NEAR(nu.variance, nu.variance_of_noise + G.dot(state.slow.covariance * G), 1e-13);
  EXPECT_NEAR(nu.squared_ratio(), 0.04 / nu.variance, 1e-12);
}

TEST(Update, CovarianceIsRightForAnyGain) {
  // (I - K Hᵀ) P (I - K Hᵀ)ᵀ + K R Kᵀ, and B - K G
  const State before = somewhere();
  const Prediction z = something();
  const Vector H = stated(z);
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 100; ++i) {
    State state = before;
    const Innovation nu = innovation(state, z, 0.5);
    const Vector K = Vector::NullaryExpr([&] { return 0.3 * normal(random); });
    correct(state, nu, K);
    const Matrix left = Matrix::Identity() - K * H.transpose();
    const Matrix expected = left * before.covariance * left.transpose() + 4e-4 * K * K.transpose();
    EXPECT_LT(largest(state.covariance - expected), 1e-13);
    EXPECT_TRUE(is_covariance(state.covariance));
    EXPECT_LT(largest(state.mean - before.mean - 0.2 * K), 1e-15);
    const auto B = left * before.slow.sensitivity - K * z.by_slow.transpose();
    EXPECT_LT(largest(state.slow.sensitivity - B), 1e-13);
    EXPECT_EQ(state.slow.mean, before.slow.mean);
    EXPECT_EQ(state.slow.covariance, before.slow.covariance);
  }
}

TEST(Update, CovariancesStayPositiveDefiniteOverThousandsOfUpdates) {
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  State state = somewhere();
  for (int i = 0; i < 20'000; ++i) {
    const Prediction z = any_prediction(random, 0.0);
    const Innovation nu = innovation(state, z, normal(random));
    Vector gain = optimal_gain(nu);
    if (i % 2 == 0) gain[at::x] = gain[at::yaw_rate] = 0.0;
    correct(state, nu, gain);
    correct_slow_errors(state, nu, i % 3 == 0 ? all() : only(slow::gyro_bias));
    // Random walks; without them the covariances would converge to zero.
    state.covariance.diagonal().array() += 1e-9;
    state.slow.covariance.diagonal().array() += 1e-9;
    ASSERT_TRUE(has_covariances(state)) << i;
  }
}

TEST(Update, CorrectingAllSlowErrorsEqualsTheJointFilter) {
  // Friedland 1969: steps and any updates in turn. Friedland's form is exact for constant errors;
  // it neglects the effect of random walks on their correlation with the state.
  CarModel model;
  Tuning& t = model.tuning;
  t.gyro_bias_walk = t.gyro_scale_walk = t.wheel_scale_walk = t.stiffness_scale_walk = 0.0;
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  State state = somewhere();
  Joint joint(state);
  for (int i = 0; i < 500; ++i) {
    if (i % 3 == 0) {
      const Input input{0.3 * std::sin(0.1 * i), i % 2 == 0};
      joint.propagate(linear_step(model, input, 0.005, state));
      propagate(model, input, 0.005, state);
    }
    const Prediction z = any_prediction(random, 0.0);
    const double measured = 0.01 * normal(random);
    const Innovation nu = innovation(state, z, measured);
    correct(state, nu, optimal_gain(nu));
    correct_slow_errors(state, nu, all());
    joint.update(z, measured);
    const Joint apart(state);
    ASSERT_LT(largest(apart.mean - joint.mean), 1e-9) << i;
    ASSERT_LT(largest(apart.covariance - joint.covariance), 1e-9) << i;
    // The published covariance adds the second-order effect of a heading error on the path.
    Eigen::Matrix<double, 6, 6> P = joint.covariance.topLeftCorner<6, 6>();
    const Eigen::Vector2d way(P(at::y, at::yaw), -P(at::x, at::yaw));
    P.topLeftCorner<2, 2>() += 0.75 * way * way.transpose();
    ASSERT_LT(largest(covariance_of_motion(state) - P), 1e-9);
  }
  EXPECT_GT((state.mean - somewhere().mean).norm(), 0.01);
}

TEST(Update, ConsideredErrorsOnlyEnlargeThePublishedCovariance) {
  // The state is as with known slow errors; only the published covariance is larger.
  State considering = somewhere();
  State knowing = somewhere();
  knowing.slow.covariance.setZero();
  CarModel model;
  model.car.grip_front = model.car.grip_rear = 9.0;  // otherwise the noise depends on the grip
  std::mt19937 random(6);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 100; ++i) {
    const Prediction z = any_prediction(random, 0.0);
    const double measured = 0.1 * normal(random);
    for (State* state : {&considering, &knowing}) {
      const Innovation nu = innovation(*state, z, measured);
      correct(*state, nu, optimal_gain(nu));
      correct_slow_errors(*state, nu, none());
      propagate(model, {0.1, true}, 0.005, *state);
    }
    ASSERT_EQ(considering.mean, knowing.mean);
    ASSERT_EQ(considering.covariance, knowing.covariance);
    ASSERT_EQ(considering.slow.mean, some_slow_values());
  }
  const Eigen::Matrix<double, 6, 6> admits = covariance_of_motion(considering);
  for (Eigen::Index i = 0; i < 6; ++i) EXPECT_GT(admits(i, i), considering.covariance(i, i)) << i;
}

TEST(Update, OnlyTheSelectedSlowErrorsChange) {
  const State before = somewhere();
  State state = before;
  const Innovation nu = innovation(state, something(), 0.5);
  correct(state, nu, optimal_gain(nu));
  correct_slow_errors(state, nu, only(slow::gyro_bias));
  for (Eigen::Index i = 0; i < slow::size; ++i) {
    const bool corrected = i == slow::gyro_bias;
    EXPECT_EQ(state.slow.mean[i] == before.slow.mean[i], !corrected) << i;
    EXPECT_EQ(state.slow.covariance(i, i) == before.slow.covariance(i, i), !corrected) << i;
  }
  EXPECT_LT(state.variance(slow::gyro_bias), before.variance(slow::gyro_bias));
  EXPECT_TRUE(is_covariance(state.slow.covariance));
}

TEST(Update, SlackOnlyIncreasesTheGain) {
  const State before = somewhere();
  Prediction z = something();
  z.slack = 3e-4;
  const Innovation nu = innovation(before, z, 0.5);
  EXPECT_EQ(nu.variance, innovation(before, something(), 0.5).variance);
  z.variance -= z.slack;
  z.slack = 0.0;
  const Vector bolder = optimal_gain(innovation(before, z, 0.5));
  EXPECT_LT(largest(optimal_gain(nu) - bolder), 1e-12);
}

TEST(Settle, ThePoseIsNoLongerCorrectedAndTheErrorStaysInItsCovariance) {
  State state = somewhere();
  const State before = state;
  detach_from_pose(state, slow::gyro_bias);
  EXPECT_TRUE(state.slow.sensitivity.col(slow::gyro_bias).head<3>().isZero(0.0));
  EXPECT_EQ(state.mean, before.mean);
  EXPECT_EQ(state.covariance.bottomRows<9>(), before.covariance.bottomRows<9>());
  State uncorrelated = before;
  uncorrelated.slow.covariance.setZero();
  uncorrelated.variance(slow::gyro_bias) = before.variance(slow::gyro_bias);
  State settled = uncorrelated;
  detach_from_pose(settled, slow::gyro_bias);
  EXPECT_LT(largest((joint_covariance(settled) - joint_covariance(uncorrelated)).diagonal()),
            1e-15);
  EXPECT_TRUE(is_covariance(state.covariance));

  // A later correction of the bias no longer moves the pose.
  Prediction z;
  z.value = state.slow.mean[slow::gyro_bias];
  z.variance = 1e-6;
  z.by_slow[slow::gyro_bias] = 1.0;
  const Innovation nu = innovation(state, z, z.value + 0.1);
  correct_slow_errors(state, nu, only(slow::gyro_bias));
  EXPECT_EQ(state.mean.head<3>(), before.mean.head<3>());
  EXPECT_NE(state.mean[at::steering_offset], before.mean[at::steering_offset]);
  EXPECT_NEAR(state.slow.mean[slow::gyro_bias], before.slow.mean[0] + 0.1, 1e-3);
}

TEST(Forget, RemovesAllCorrelations) {
  State state = somewhere();
  const State before = state;
  forget(state, at::v_y, 0.3);
  EXPECT_NEAR(covariance_of_motion(state)(at::v_y, at::v_y), 0.09, 1e-15);
  Matrix expected = before.covariance;
  expected.row(at::v_y).setZero();
  expected.col(at::v_y).setZero();
  expected(at::v_y, at::v_y) = state.variance(at::v_y);
  EXPECT_EQ(state.covariance, expected);
  EXPECT_TRUE(is_covariance(state.covariance));
}

}  // namespace
}  // namespace odomd::estimator::full::testing::update_test
