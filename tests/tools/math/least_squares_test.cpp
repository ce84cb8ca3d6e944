// Least squares, compared with known solutions.
#include "tools/math/least_squares.hpp"

#include "tests/gtest.hpp"
#include "tools/math/random.hpp"

namespace odomd::tools::least_squares_test {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double unknown = std::numeric_limits<double>::infinity();

// y = 2 exp(-0.5 t)
struct Decay {
  VectorXd t, y;

  explicit Decay(double noise, std::uint64_t seed = 1) : t(VectorXd::LinSpaced(400, 0.0, 8.0)) {
    sim::RandomStream random(seed, "decay");
    y = 2.0 * (-0.5 * t.array()).exp();
    for (double& value : y) value += noise * random.normal();
  }
  [[nodiscard]] LeastSquares problem() const {
    return {.residuals = [this](const VectorXd& p) -> VectorXd {
              return y - p[0] * (-p[1] * t.array()).exp().matrix();
            },
            .step = VectorXd::Constant(2, 1e-6),
            .start = VectorXd::Ones(2),
            .expected = VectorXd::Ones(2),
            .prior_sigma = VectorXd::Constant(2, unknown),
            .enough = 1e-9};
  }
};

TEST(LeastSquares, FindsParametersWithTheirUncertainties) {
  int inside = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Decay decay(0.1, seed);
    const LeastSquaresSolution found = solve(decay.problem());
    EXPECT_TRUE(found.settled);
    EXPECT_NEAR(found.noise, 0.1, 0.02);
    EXPECT_LT(std::sqrt(found.inverse(1, 1)), 0.03);
    inside += std::fabs(found.parameters[1] - 0.5) < 2.0 * std::sqrt(found.inverse(1, 1));
  }
  EXPECT_GE(inside, 17);
}

TEST(LeastSquares, GivesTheSameResultWithGivenDerivativesAndWithDifferences) {
  const Decay decay(0.1);
  LeastSquares problem = decay.problem();
  const LeastSquaresSolution by_differences = solve(problem);
  problem.derivatives = [&decay](const VectorXd& p) {
    const VectorXd e = (-p[1] * decay.t.array()).exp();
    Eigen::MatrixXd all(e.size(), 2);
    all << e, -p[0] * decay.t.cwiseProduct(e);
    return all;
  };
  EXPECT_LT((solve(problem).parameters - by_differences.parameters).norm(), 1e-5);
}

TEST(LeastSquares, ReducesTheWeightOfOutliersUnlessHuberIsOff) {
  Decay decay(0.01);
  for (Index i = 0; i < decay.y.size(); i += 10) decay.y[i] += 1.0;
  LeastSquares problem = decay.problem();
  const LeastSquaresSolution robust = solve(problem);
  EXPECT_NEAR(robust.parameters[0], 2.0, 0.02);
  EXPECT_LT(robust.weights[0], 0.1);
  problem.huber = no_huber;
  EXPECT_GT(solve(problem).parameters[0], robust.parameters[0] + 0.02);
}

TEST(LeastSquares, WeighsPriorsAgainstResiduals) {
  const Decay decay(0.1);
  LeastSquares problem = decay.problem();
  problem.expected[1] = 0.8;
  problem.prior_sigma[1] = 1e-6;
  EXPECT_NEAR(solve(problem).parameters[1], 0.8, 1e-5);
  problem.prior_sigma[1] = 0.01;
  const double held = solve(problem).parameters[1];
  problem.together = 100.0;
  EXPECT_GT(solve(problem).parameters[1], held + 0.05);
}

// Each value occurs four times: only a quarter of them is information.
TEST(LeastSquares, CountsCorrelatedResidualsOnce) {
  const Decay decay(0.0);
  sim::RandomStream random(2, "noise");
  VectorXd y = decay.y;
  std::vector<std::size_t> block, own;
  double noise = 0.0;
  for (Index i = 0; i < y.size(); ++i) {
    if (i % 4 == 0) noise = 0.1 * random.normal();
    y[i] += noise;
    block.push_back(static_cast<std::size_t>(i / 4));
    own.push_back(static_cast<std::size_t>(i));
  }
  LeastSquares problem = decay.problem();
  problem.residuals = [&](const VectorXd& p) -> VectorXd {
    return y - p[0] * (-p[1] * decay.t.array()).exp().matrix();
  };
  const LeastSquaresSolution found = solve(problem);
  const double together = covariance_by_blocks(problem, found, block)(0, 0);
  EXPECT_NEAR(std::sqrt(together / found.inverse(0, 0)), 2.0, 0.5);
  EXPECT_NEAR(std::sqrt(covariance_by_blocks(problem, found, own)(0, 0) / found.inverse(0, 0)), 1.0,
              0.2);
  EXPECT_DOUBLE_EQ(covariance_by_blocks(problem, found, block, 4.0)(0, 0), 4.0 * together);
}

TEST(LeastSquares, FindsTheBestTrialAndReportsIfItDoesNotConverge) {
  const Decay decay(0.01);
  LeastSquares problem = decay.problem();
  problem.start[0] = 2.0;
  EXPECT_EQ(best_of(problem, 1, {0.1, 0.4, 0.7, 1.0}, 0.01), 0.4);
  EXPECT_LT(cost_of(problem, Eigen::Vector2d(2.0, 0.5), 0.01),
            cost_of(problem, Eigen::Vector2d(2.0, 0.4), 0.01));
  problem.iterations = 1;
  EXPECT_FALSE(solve(problem).settled);
}

}  // namespace
}  // namespace odomd::tools::least_squares_test
