// Least squares over all rows, and without the rows of some sources.
#include "estimator/integrity/consensus.hpp"

#include <initializer_list>

#include "tests/gtest.hpp"

namespace odomd::estimator::integrity::consensus_test {
namespace {

Row row(Sources sources, std::initializer_list<std::pair<of::Index, double>> by, double z,
        double sigma) {
  Row made{.sources = sources, .z = z, .sigma = sigma};
  for (const auto& [index, value] : by) made.by[index] = value;
  return made;
}

/// Weak priors for all unknowns.
Consensus of_next_to_nothing() {
  Consensus all;
  for (const of::Index index : {of::speed, of::yaw_rate, of::front_slip, of::rear_slip})
    all.add(row(0, {{index, 1.0}}, 0.0, 1e6));
  return all;
}

TEST(Consensus, SolvesTwoEquationsOfTwoUnknowns) {
  // 2 v + ψ̇ = 5, v - ψ̇ = 1: v = 2, ψ̇ = 1.
  Consensus all = of_next_to_nothing();
  all.add(row(only(Source::motor), {{of::speed, 2.0}, {of::yaw_rate, 1.0}}, 5.0, 0.1));
  all.add(row(only(Source::yaw_rate), {{of::speed, 1.0}, {of::yaw_rate, -1.0}}, 1.0, 0.2));
  const Solution solution = all.without(0);
  EXPECT_NEAR(solution.motion[of::speed], 2.0, 1e-9);
  EXPECT_NEAR(solution.motion[of::yaw_rate], 1.0, 1e-9);
  // v = (z1 + z2) / 3, ψ̇ = (z1 - 2 z2) / 3.
  EXPECT_NEAR(solution.sigma[of::speed], std::hypot(0.1, 0.2) / 3.0, 1e-9);
  EXPECT_NEAR(solution.sigma[of::yaw_rate], std::hypot(0.1, 0.4) / 3.0, 1e-9);
  EXPECT_NEAR(solution.misfit, 0.0, 1e-9);
}

TEST(Consensus, WeighsByTheSigmasAndReturnsTheMisfit) {
  Consensus all = of_next_to_nothing();
  all.add(row(only(Source::wheel_rear), {{of::speed, 1.0}}, 1.0, 0.1));
  all.add(row(only(Source::motor), {{of::speed, 1.0}}, 2.0, 0.2));
  const Solution solution = all.without(0);
  EXPECT_NEAR(solution.motion[of::speed], 1.2, 1e-9);
  EXPECT_NEAR(solution.sigma[of::speed], std::sqrt(1.0 / 125.0), 1e-9);
  EXPECT_NEAR(solution.misfit, 1.0 / (0.01 + 0.04), 1e-6);
}

TEST(Consensus, LeavingOutTheOneThatIsWrongExplainsItAndAnotherDoesNot) {
  Consensus all = of_next_to_nothing();
  for (const Source source : {Source::wheel_rear_left, Source::wheel_rear_right, Source::motor})
    all.add(row(only(source), {{of::speed, 1.0}}, source == Source::motor ? 3.0 : 1.0, 0.1));
  EXPECT_GT(all.without(0).misfit, 200.0);
  EXPECT_NEAR(all.without(only(Source::motor)).misfit, 0.0, 1e-6);
  EXPECT_NEAR(all.without(only(Source::motor)).motion[of::speed], 1.0, 1e-6);
  EXPECT_GT(all.without(only(Source::wheel_rear_left)).misfit, 100.0);
  EXPECT_NEAR(all.without(only(Source::wheel_rear_left) | only(Source::wheel_rear_right)).misfit,
              0.0, 1e-6);
}

TEST(Consensus, ARowOfSeveralSourcesGoesWithAnyOfThem) {
  Consensus all = of_next_to_nothing();
  all.add(row(only(Source::steering) | only(Source::motor), {{of::yaw_rate, 1.0}}, 2.0, 0.1));
  EXPECT_NEAR(all.without(0).motion[of::yaw_rate], 2.0, 1e-6);
  EXPECT_NEAR(all.without(only(Source::motor)).motion[of::yaw_rate], 0.0, 1e-6);
  EXPECT_NEAR(all.without(only(Source::yaw_rate)).motion[of::yaw_rate], 2.0, 1e-6);
}

TEST(Consensus, TakesNoMoreThanItHolds) {
  Consensus all = of_next_to_nothing();
  for (std::size_t i = 0; i < 2 * Consensus::capacity; ++i)
    all.add(row(only(Source::motor), {{of::speed, 1.0}}, 1.0, 0.1));
  EXPECT_EQ(static_cast<std::size_t>(all.end() - all.begin()), Consensus::capacity);
  EXPECT_NEAR(all.without(0).motion[of::speed], 1.0, 1e-6);
}

}  // namespace
}  // namespace odomd::estimator::integrity::consensus_test
