// The gyro's prediction against its header's equation and differences.
#include "estimator/ekf/yaw_rate.hpp"

#include <gtest/gtest.h>

#include "derivatives.hpp"
#include "states.hpp"

namespace odomd::estimator::full::yaw_rate_test {
namespace {

TEST(YawRate, IsScaledAndBiased) {
  for (const State& state : testing::grid_of_states()) {
    const Prediction z = predict_yaw_rate(state, 0.03);
    EXPECT_NEAR(z.value, 1.01 * state.mean[at::yaw_rate] + 0.02, 1e-15);
    EXPECT_EQ(z.variance, 0.03 * 0.03);
  }
}

TEST(YawRate, DependsOnTheStateAsItSays) {
  const auto predict = [](const State& state) { return predict_yaw_rate(state, 0.03); };
  for (const State& state : testing::grid_of_states()) {
    EXPECT_LT((testing::stated(predict(state)) - testing::differences(state, predict))
                  .cwiseAbs()
                  .maxCoeff(),
              1e-8);
  }
}

}  // namespace
}  // namespace odomd::estimator::full::yaw_rate_test
