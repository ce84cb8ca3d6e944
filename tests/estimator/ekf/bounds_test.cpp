#include "estimator/ekf/publication.hpp"

#include <limits>

#include <Eigen/Eigenvalues>

#include "states.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::full::testing::bounds_test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

State some_state() {
  State state = grid_of_states().front();
  state.covariance = some_covariance();
  state.slow = some_slow_errors();
  return state;
}

TEST(Sound, IsWhatACarMayBe) {
  for (State state : grid_of_states()) {
    state.covariance = some_covariance();
    state.slow = some_slow_errors();
    EXPECT_TRUE(is_valid(state));
  }
}

TEST(Sound, IsNoStateWithANumberThatIsNone) {
  const auto expect_refused = [](const auto& change) {
    State state = some_state();
    change(state);
    EXPECT_FALSE(is_valid(state));
  };
  for (const double value : {nan, infinity, -infinity}) {
    for (Eigen::Index i = 0; i < at::size; ++i) {
      SCOPED_TRACE(i);
      expect_refused([&](State& s) { s.mean[i] = value; });
      for (Eigen::Index j = 0; j <= i; ++j)
        expect_refused([&](State& s) { s.covariance(i, j) = s.covariance(j, i) = value; });
      for (Eigen::Index j = 0; j < slow::size; ++j)
        expect_refused([&](State& s) { s.slow.sensitivity(i, j) = value; });
    }
    for (Eigen::Index i = 0; i < slow::size; ++i) {
      SCOPED_TRACE(i);
      expect_refused([&](State& s) { s.slow.mean[i] = value; });
      for (Eigen::Index j = 0; j <= i; ++j) {
        expect_refused(
            [&](State& s) { s.slow.covariance(i, j) = s.slow.covariance(j, i) = value; });
      }
    }
  }
}

TEST(Sound, IsNoStateBeyondWhatACarDoes) {
  for (const auto& [index, value] : {std::pair{at::x, 2e9},
                                     {at::y, -2e9},
                                     {at::v_x, 301.0},
                                     {at::yaw_rate, -101.0},
                                     {at::front_angle, 2e4},
                                     {at::steering_offset, -2e4}}) {
    State state = some_state();
    state.mean[index] = value;
    EXPECT_FALSE(is_valid(state)) << index;
  }
  State state = some_state();
  state.slow.mean[slow::wheel_scale] = 2e4;
  EXPECT_FALSE(is_valid(state));
}

TEST(Sound, IsACovarianceWhoseEigenvaluesArePositive) {
  const State state = some_state();
  const double smallest =
      Eigen::SelfAdjointEigenSolver<Matrix>(state.covariance).eigenvalues().minCoeff();
  for (const double share : {1.0 - 1e-6, 1.0 + 1e-6}) {
    State less = state;
    less.covariance.diagonal().array() -= share * smallest;
    EXPECT_EQ(is_valid(less), share < 1.0);
  }
}

TEST(Limit, BringsVariancesDownAndLeavesCorrelations) {
  State state = some_state();
  Matrix& P = state.covariance;
  P = some_covariance(1e9);
  state.slow = some_slow_errors(1e6);
  const Vector before = P.diagonal();
  const double correlation = P(0, 4) / std::sqrt(P(0, 0) * P(4, 4));
  limit(state);
  EXPECT_LE(P(at::x, at::x), 1e6 * (1.0 + 1e-8));
  EXPECT_LE(P(at::yaw, at::yaw), 10.24 * (1.0 + 1e-8));
  EXPECT_LT(P(at::v_y, at::v_y), before[at::v_y]);
  EXPECT_NEAR(P(0, 4) / std::sqrt(P(0, 0) * P(4, 4)), correlation, 1e-8);
  EXPECT_TRUE(is_covariance(P));
  EXPECT_LE(state.slow.covariance.diagonal().maxCoeff(), 4.0 * (1.0 + 1e-8));
  EXPECT_TRUE(is_covariance(state.slow.covariance));
}

TEST(Limit, HardlyTouchesWhatIsBelow) {
  State state = some_state();
  const State before = state;
  limit(state);
  const auto grown = [](const auto& after, const auto& earlier) {
    return (after.diagonal().array() > earlier.diagonal().array()).all() &&
           largest(after - earlier) < 2e-9 * earlier.cwiseAbs().maxCoeff();
  };
  EXPECT_TRUE(grown(state.covariance, before.covariance));
  EXPECT_TRUE(grown(state.slow.covariance, before.slow.covariance));
  EXPECT_EQ(state.mean, before.mean);
  EXPECT_EQ(state.slow.sensitivity, before.slow.sensitivity);
}

}  // namespace
}  // namespace odomd::estimator::full::testing::bounds_test
