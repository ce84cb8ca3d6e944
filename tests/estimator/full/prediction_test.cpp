// The update of mean and covariance by a scalar sample, against the textbook's.
#include "estimator/ekf/prediction.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "derivatives.hpp"
#include "states.hpp"

namespace odomd::estimator::full::prediction_test {
namespace {

using testing::is_covariance;
using testing::some_covariance;
using testing::stated;

constexpr Teaches everything{.yaw_rate = true, .gyro_bias = true};

State somewhere() {
  State state;
  state.mean << 3.0, -2.0, 0.7, 1.5, 0.1, 0.8, 0.6, 0.4, 0.1, 0.01, -0.08, 0.02, 0.01, -0.2, 0.015;
  state.covariance = some_covariance();
  return state;
}

/// Depends on states all over the vector.
Prediction something() {
  Prediction z;
  z.value = 0.3;
  z.variance = 4e-4;
  z.depends_on(at::yaw, 0.7);
  z.depends_on(at::v_y, -1.3);
  z.depends_on(at::accel_bias_x, 0.2);
  z.depends_on(at::wheel_scale, 2.0);
  return z;
}

TEST(Prediction, InnovationIsTheTextbooks) {
  const State state = somewhere();
  const Vector H = stated(something());
  const Innovation nu = innovation(state, something(), 0.5);
  EXPECT_NEAR(nu.value, 0.2, 1e-15);
  EXPECT_NEAR(nu.variance, H.dot(state.covariance * H) + 4e-4, 1e-15);
  EXPECT_LT((nu.covariance_with_state - state.covariance * H).cwiseAbs().maxCoeff(), 1e-15);
  EXPECT_NEAR(nu.squared_ratio(), 0.04 / nu.variance, 1e-12);
}

TEST(Prediction, OptimalUpdateIsTheTextbooks) {
  // P = (P⁻¹ + H R⁻¹ Hᵀ)⁻¹, the information form: nothing in common with the code.
  const State before = somewhere();
  const Vector H = stated(something());
  State state = before;
  const Innovation nu = innovation(state, something(), 0.5);
  correct(state, nu, optimal_gain(nu));
  const Matrix information = before.covariance.inverse() + H * H.transpose() / 4e-4;
  const Matrix expected = information.inverse();
  EXPECT_LT((state.covariance - expected).cwiseAbs().maxCoeff(), 1e-12);
  const Vector mean = before.mean + expected * H * (0.2 / 4e-4);
  EXPECT_LT((state.mean - mean).cwiseAbs().maxCoeff(), 1e-11);
}

TEST(Prediction, AnyGainLeavesTheCovarianceOfTheErrorItMakes) {
  // (I - K Hᵀ) P (I - K Hᵀ)ᵀ + K R Kᵀ
  const State before = somewhere();
  const Vector H = stated(something());
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 100; ++i) {
    State state = before;
    const Innovation nu = innovation(state, something(), 0.5);
    const Vector K = Vector::NullaryExpr([&] { return 0.3 * normal(random); });
    correct(state, nu, K);
    const Matrix left = Matrix::Identity() - K * H.transpose();
    const Matrix expected = left * before.covariance * left.transpose() + 4e-4 * K * K.transpose();
    EXPECT_LT((state.covariance - expected).cwiseAbs().maxCoeff(), 1e-13);
    EXPECT_TRUE(is_covariance(state.covariance));
    EXPECT_LT((state.mean - before.mean - 0.2 * K).cwiseAbs().maxCoeff(), 1e-15);
  }
}

TEST(Prediction, CovarianceStaysOneThroughThousandsOfUpdates) {
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  State state = somewhere();
  for (int i = 0; i < 20'000; ++i) {
    Prediction z;
    z.variance = std::pow(10.0, -8.0 + 3.0 * normal(random));
    for (int n = 0; n < 3; ++n) {
      z.depends_on(static_cast<at::Index>(random() % at::size), normal(random));
    }
    const Innovation nu = innovation(state, z, normal(random));
    correct(state, nu,
            i % 2 == 0 ? optimal_gain(nu) : gain_of_own_sensors(state, nu, 0.004, everything));
    // What varies slowly does so: or everything would be known in the end.
    state.covariance.diagonal().array() += 1e-9;
    ASSERT_TRUE(is_covariance(state.covariance)) << i;
  }
}

TEST(Prediction, OwnSensorsLeaveTheScalesToTheCamera) {
  const State before = somewhere();
  State state = before;
  const Innovation nu = innovation(state, something(), 0.5);
  correct(state, nu, gain_of_own_sensors(state, nu, 0.004, everything));
  for (const at::Index scale : {at::stiffness_scale, at::gyro_scale, at::wheel_scale}) {
    EXPECT_EQ(state.mean[scale], before.mean[scale]);
    EXPECT_EQ(state.covariance(scale, scale), before.covariance(scale, scale));
  }
  for (const at::Index learnt : {at::v_x, at::v_y, at::yaw_rate, at::front_force, at::accel_bias_x,
                                 at::steering_offset, at::gyro_bias, at::accel_bias_y}) {
    EXPECT_NE(state.mean[learnt], before.mean[learnt]);
    EXPECT_LT(state.covariance(learnt, learnt), before.covariance(learnt, learnt));
  }
}

TEST(Prediction, YawRateAndGyroBiasAreLeftAloneByWhatDoesNotTeachThem) {
  const State before = somewhere();
  State state = before;
  const Innovation nu = innovation(state, something(), 0.5);
  correct(state, nu, gain_of_own_sensors(state, nu, 0.004, {}));
  for (const at::Index kept : {at::yaw, at::yaw_rate, at::gyro_bias}) {
    EXPECT_EQ(state.mean[kept], before.mean[kept]);
  }
  EXPECT_NE(state.mean[at::v_x], before.mean[at::v_x]);
  EXPECT_TRUE(is_covariance(state.covariance));
}

TEST(Prediction, OwnSensorsMoveThePoseByHalfTheTimeTheSourceWasUnheard) {
  // An error that has grown evenly was half as large on the way.
  const State before = somewhere();
  State state = before;
  const Innovation nu = innovation(state, something(), 0.5);
  correct(state, nu, gain_of_own_sensors(state, nu, 0.004, everything));
  const Vector change = state.mean - before.mean;
  const double half = 0.5 * 0.004;
  const double c = std::cos(before.mean[at::yaw]);
  const double s = std::sin(before.mean[at::yaw]);
  EXPECT_NEAR(change[at::x], half * (c * change[at::v_x] - s * change[at::v_y]), 1e-16);
  EXPECT_NEAR(change[at::y], half * (s * change[at::v_x] + c * change[at::v_y]), 1e-16);
  EXPECT_NEAR(change[at::yaw], half * change[at::yaw_rate], 1e-16);
  EXPECT_NE(change[at::x], 0.0);
  EXPECT_TRUE(is_covariance(state.covariance));
}

}  // namespace
}  // namespace odomd::estimator::full::prediction_test
