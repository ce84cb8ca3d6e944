// Compares the gyro's prediction with its equation and with central differences.
#include "estimator/ekf/predict.hpp"

#include "derivatives.hpp"
#include "states.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::full::gyro_test {
namespace {

TEST(Gyro, IsScaledAndBiased) {
  for (const State& state : testing::grid_of_states()) {
    const Prediction z = predict_yaw_rate(state, 0.03);
    EXPECT_NEAR(z.value, 1.01 * state.mean[at::yaw_rate] + 0.02, 1e-15);
    EXPECT_EQ(z.variance, 0.03 * 0.03);
    EXPECT_EQ(z.slack, 0.0);
  }
}

TEST(Gyro, DerivativesByStateAndSlowErrorsAreRight) {
  const auto predict = [](const State& state) { return predict_yaw_rate(state, 0.03); };
  for (const State& state : testing::grid_of_states()) {
    const Prediction z = predict(state);
    EXPECT_LT((testing::stated(z) - testing::differences(state, predict)).cwiseAbs().maxCoeff(),
              1e-8);
    EXPECT_LT((z.by_slow - testing::differences_by_slow(state, predict)).cwiseAbs().maxCoeff(),
              1e-8);
  }
}

}  // namespace
}  // namespace odomd::estimator::full::gyro_test
