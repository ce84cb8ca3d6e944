// Steps between samples: their length, the steering actuator, and a standing car.
#include "estimator/ekf/take.hpp"
#include "tests/estimator/signalled_car.hpp"

namespace odomd::estimator::full::testing::advance_test {
namespace {

TEST(Advance, StepsAreAtMostAPeriodLong) {
  Car car = car_after(1.0, straight_at(1.0));
  car.state.mean[at::yaw_rate] = 0.5;
  State whole = car.state;
  State stepped = car.state;
  advance(car.context, whole, whole.time_ns + 10 * period_ns);
  for (int i = 0; i < 10; ++i) advance(car.context, stepped, stepped.time_ns + period_ns);
  EXPECT_EQ(whole.time_ns, stepped.time_ns);
  EXPECT_LT(largest(whole.mean - stepped.mean), 1e-9);
  EXPECT_LT(largest(whole.covariance - stepped.covariance), 1e-9);
}

/// The front wheels' angle after each of `count` periods since a command of 0.3 rad.
std::vector<double> commanded(const SteeringActuator& actuator, int count) {
  Car car;
  car.context.model.car.steering = actuator;
  car.drive(1.0, straight_at(1.0));
  car.push(Source::steering, 0.3);
  std::vector<double> angles;
  for (int i = 0; i < count; ++i) {
    advance(car.context, car.state, car.state.time_ns + period_ns);
    angles.push_back(input_of(car.state).steering);
  }
  return angles;
}

TEST(Advance, TheFrontWheelsFollowACommandWithLagAndRateLimit) {
  EXPECT_EQ(commanded({}, 1).back(), 0.3);
  constexpr double lag_s = 0.1;
  const std::vector<double> lags = commanded({.lag_s = lag_s}, 60);
  const std::vector<double> limited = commanded({.rate_limit = 2.0}, 40);
  for (std::size_t i = 0; i < lags.size(); ++i) {
    const double t = 0.005 * static_cast<double>(i + 1);
    EXPECT_NEAR(lags[i], 0.3 * (1.0 - std::exp(-t / lag_s)), 0.005) << t;
  }
  for (std::size_t i = 0; i < limited.size(); ++i)
    EXPECT_NEAR(limited[i], std::min(0.3, 0.01 * static_cast<double>(i + 1)), 1e-12) << i;
  // The slower of the two limits applies.
  EXPECT_NEAR(commanded({.lag_s = 0.01, .rate_limit = 2.0}, 1).back(), 0.01, 1e-12);
  EXPECT_LT(commanded({.lag_s = 1.0, .rate_limit = 2.0}, 1).back(), 0.002);
}

TEST(Advance, NeverGoesBack) {
  Car car = car_after(1.0, straight_at(1.0));
  const State before = car.state;
  advance(car.context, car.state, before.time_ns - period_ns);
  advance(car.context, car.state, before.time_ns);
  EXPECT_EQ(car.state.time_ns, before.time_ns);
  EXPECT_EQ(car.state.mean, before.mean);
  EXPECT_EQ(car.state.covariance, before.covariance);
}

TEST(Advance, AStandingCarOnlyLosesItsCalibrations) {
  Car car = car_at_rest(1.0);
  const State before = car.state;
  advance(car.context, car.state, before.time_ns + 400 * period_ns);
  State expected = before;
  propagate_standing(car.context.model, 400 * 0.005, expected);
  EXPECT_EQ(car.state.mean, before.mean);
  EXPECT_LT(largest(car.state.covariance - expected.covariance), 1e-12);
  EXPECT_LT(largest(car.state.slow.covariance - expected.slow.covariance), 1e-12);
}

}  // namespace
}  // namespace odomd::estimator::full::testing::advance_test
