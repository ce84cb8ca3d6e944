// The parity equations: the true motion of a car satisfies all of them. Also their least-squares
// solution, with and without the rows of some sources.
#include "estimator/integrity/equations.hpp"

#include <initializer_list>

#include "estimator/common/vehicle.hpp"
#include "estimator/integrity/consensus.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::integrity::equations_test {
namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t start_ns = 1'000'000 * ms;

/// The observations of a car that has driven on a circle for a while, with a camera.
struct Circle {
  double speed = 2.0;
  double turn = 1.0;

  static constexpr std::int64_t now_ns = start_ns + 5'000 * ms;

  [[nodiscard]] double steering() const { return std::atan(turn * Vehicle{}.wheelbase() / speed); }
  [[nodiscard]] double wheel(Source source) const {
    const Vehicle car;
    const WheelPlace place = wheel_place(car, source);
    const double along = speed - place.left * turn;
    return std::copysign(std::hypot(along, place.steered ? car.wheelbase() * turn : 0.0), along);
  }

  [[nodiscard]] Observations observed() const {
    Observations observed;
    observed.now_ns = now_ns;
    observed.last_consensus.fill(
        {.motion = {speed, turn, 0.0, 0.0}, .sigma = Eigen::Vector2d::Constant(0.1)});
    observed.integrated_speed = speed;
    observed.integrated_sigma = 0.1;
    const auto push = [&observed](Source source, double value, double sigma) {
      for (std::int64_t t = start_ns; t <= now_ns; t += 10 * ms)
        add_sample(observed.sources[index_of(source)], t, value, sigma, false);
    };
    for (const Source source : wheel_sources) push(source, wheel(source), 0.01);
    push(Source::yaw_rate, turn, 0.005);
    push(Source::accel_x, 0.0, 0.1);
    push(Source::accel_y, speed * turn, 0.1);
    push(Source::steering, steering(), 0.002);
    for (std::int64_t t = start_ns; t <= now_ns; t += 10 * ms) {
      add_sample(observed.camera_speed, t, speed, 0.008, false);
      add_sample(observed.camera_yaw_rate, t, turn, 0.009, false);
    }
    return observed;
  }

  [[nodiscard]] Motion truth() const {
    Motion motion = Motion::Zero();
    motion[of::speed] = speed;
    motion[of::yaw_rate] = turn;
    return motion;
  }
};

Consensus equations_of(const Observations& observed, Over over = Over::short_time) {
  return equations({}, observed, false, over);
}

/// Adds an error to the means of a source.
void add_error(Observations& observed, Source source, double error) {
  for (Mean& mean : observed.sources[index_of(source)].means)
    mean = {mean.value + error, mean.slow + error};
}

/// Largest deviation of the truth from a source's rows, in sigmas; NaN without a row.
double off(const Consensus& all, Source source, const Motion& truth) {
  double most = NAN;
  for (const Row& row : all)
    if ((row.sources & only(source)) != 0) most = std::fmax(most, std::abs(row.off(truth)));
  return most;
}

TEST(Equations, TheTrueMotionOnACircleFitsAllWithinASigma) {
  for (const Circle circle : {Circle{2.0, 1.0}, Circle{2.0, -1.0}, Circle{0.5, 0.8},
                              Circle{-1.5, 0.6}, Circle{3.0, 0.0}}) {
    const Observations observed = circle.observed();
    for (const Over over : {Over::short_time, Over::long_time}) {
      const Consensus all = equations_of(observed, over);
      for (const Row& row : all)
        EXPECT_LT(std::abs(row.off(circle.truth())), 1.0)
            << circle.speed << " m/s, " << circle.turn << " rad/s, sources " << row.sources;
      // The consensus is the true motion.
      const Solution solution = all.without(0);
      EXPECT_NEAR(solution.motion[of::speed], circle.speed, 0.05);
      EXPECT_NEAR(solution.motion[of::yaw_rate], circle.turn, 0.05);
    }
  }
}

TEST(Equations, EverySourceThatKnowsTheMotionHasARow) {
  const Circle circle;
  const Consensus all = equations_of(circle.observed());
  for (const Source source : all_sources) {
    const bool knows = source != Source::direction;
    EXPECT_EQ(off(all, source, circle.truth()) >= 0.0, knows) << source_names[index_of(source)];
  }
}

TEST(Equations, ASilentSourceHasNoRow) {
  const Circle circle;
  Observations observed = circle.observed();
  observed.sources[index_of(Source::steering)] = {};
  observed.sources[index_of(Source::wheel_front_left)].arrival_ns -= 500 * ms;
  const Consensus all = equations_of(observed);
  EXPECT_TRUE(std::isnan(off(all, Source::steering, circle.truth())));
  EXPECT_TRUE(std::isnan(off(all, Source::wheel_front_left, circle.truth())));
}

TEST(Equations, AFrontWheelMeasuresItsSpeedAlongTheWheel) {
  // In a tight turn a front wheel is faster than the rear wheel on its side.
  const Circle circle{1.0, 1.8};
  EXPECT_GT(circle.wheel(Source::wheel_front_right), circle.wheel(Source::wheel_rear_right));
  const Consensus all = equations_of(circle.observed());
  EXPECT_LT(off(all, Source::wheel_front_right, circle.truth()), 0.1);
  // The front wheel's equation contains the slip of its own axle only.
  for (const Row& row : all) {
    const bool front = row.sources == only(Source::wheel_front_right);
    if (!front && row.sources != only(Source::wheel_rear_right)) continue;
    EXPECT_EQ(row.by[of::front_slip] != 0.0, front);
    EXPECT_EQ(row.by[of::rear_slip] != 0.0, !front);
  }
}

TEST(Equations, AFrontWheelOfASpinningCarRollsForwardsThoughItsPlaceMovesBackwards) {
  const Circle spin{0.3, 8.0};
  const Vehicle car;
  const WheelPlace place = wheel_place(car, Source::wheel_front_left);
  const double rear_slip = 1.0;
  const double along = spin.speed - place.left * spin.turn;
  ASSERT_LT(along, 0.0);
  const double across = rear_slip + car.wheelbase() * spin.turn;
  const double tan = std::tan(0.5);
  const double delta = std::atan(car.wheelbase() * tan / (car.wheelbase() - place.left * tan));
  Observations observed = spin.observed();
  observed.errors.rear_slip = rear_slip;
  observed.sources[index_of(Source::steering)].means.fill({0.5, 0.5});
  const double rolls = along * std::cos(delta) + across * std::sin(delta);
  ASSERT_GT(rolls, 0.0);
  observed.sources[index_of(Source::wheel_front_left)].means.fill({rolls, rolls});
  const Consensus all = equations_of(observed);
  EXPECT_LT(off(all, Source::wheel_front_left, spin.truth()), 0.1);
}

TEST(Equations, AnErrorOfASourceShowsInItsRow) {
  for (const auto& [source, error] : {std::pair{Source::yaw_rate, 0.5},
                                      {Source::accel_y, 3.0},
                                      {Source::wheel_rear_left, 0.7},
                                      {Source::wheel_front_right, 0.7}}) {
    const Circle circle;
    Observations observed = circle.observed();
    add_error(observed, source, error);
    EXPECT_GT(off(equations_of(observed), source, circle.truth()), 3.0)
        << source_names[index_of(source)];
  }
}

TEST(Equations, SteeringBeyondTheGripPredictsNoYawRate) {
  // At 6 m/s and 3 rad/s, a_y would be 18 m/s²: the front slides at any steering angle.
  const Circle sliding{6.0, 1.0};
  Observations observed = sliding.observed();
  const double wheelbase = Vehicle{}.wheelbase();
  const double delta = std::atan(3.0 * wheelbase / 6.0);
  observed.now_ns += 3'000 * ms;
  for (std::int64_t t = Circle::now_ns; t <= observed.now_ns; t += 10 * ms)
    add_sample(observed.sources[index_of(Source::steering)], t, delta, 0.002, false);
  for (SourceHistory& history : observed.sources)
    if (history.seen()) history.time_ns = observed.now_ns;
  EXPECT_LT(off(equations_of(observed), Source::steering, sliding.truth()), 2.0);
}

TEST(Equations, AKnownGyroBiasIsSubtracted) {
  const Circle circle;
  Observations observed = circle.observed();
  add_error(observed, Source::yaw_rate, 0.1);
  observed.errors.gyro_bias = 0.1;
  observed.errors.gyro_bias_sigma = 0.001;
  const auto off_by = [&] {
    return off(equations_of(observed, Over::long_time), Source::yaw_rate, circle.truth());
  };
  EXPECT_LT(off_by(), 0.1);
  observed.errors.gyro_bias = 0.0;
  EXPECT_GT(off_by(), 2.0);
}

TEST(Equations, UnsignedWheelsAreReadBackwards) {
  const Circle circle{-1.5, 0.6};
  Observations observed = circle.observed();
  for (const Source source : wheel_sources)
    for (Mean& mean : observed.sources[index_of(source)].means) mean = {-mean.value, -mean.slow};
  const Consensus all = equations({}, observed, true, Over::short_time);
  for (const Row& row : all) EXPECT_LT(std::abs(row.off(circle.truth())), 1.0) << row.sources;
}

TEST(Equations, SteeringLagIsSymmetric) {
  const auto sigma_of = [](double rate) {
    Observations observed;
    observed.now_ns = Circle::now_ns;
    observed.last_consensus.fill({.motion = {1.5, 0.0, 0.0, 0.0}});
    for (std::int64_t t = start_ns; t <= Circle::now_ns; t += 20 * ms) {
      const double from_end_s = static_cast<double>(t - Circle::now_ns) * 1e-9;
      add_sample(observed.sources[index_of(Source::steering)], t, rate * from_end_s, 0.002, false);
    }
    for (const Row& row : equations_of(observed))
      if (row.sources == only(Source::steering)) return row.sigma;
    return 0.0;
  };
  EXPECT_GT(sigma_of(0.5), sigma_of(0.0));
  EXPECT_NEAR(sigma_of(0.5), sigma_of(-0.5), 1e-9);
}

// Least squares
// ------------------------------------------------------------------------------------

Row row(Sources sources, std::initializer_list<std::pair<of::Index, double>> by, double z,
        double sigma) {
  Row made{.sources = sources, .z = z, .sigma = sigma};
  for (const auto& [index, value] : by) made.by[index] = value;
  return made;
}

/// Weak priors for all unknowns.
Consensus with_weak_priors() {
  Consensus all;
  for (const of::Index index : {of::speed, of::yaw_rate, of::front_slip, of::rear_slip})
    all.add(row(0, {{index, 1.0}}, 0.0, 1e6));
  return all;
}

TEST(Consensus, SolvesTwoEquationsOfTwoUnknowns) {
  // 2 v + ψ̇ = 5, v - ψ̇ = 1: v = 2, ψ̇ = 1.
  Consensus all = with_weak_priors();
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
  Consensus all = with_weak_priors();
  all.add(row(only(Source::wheel_rear), {{of::speed, 1.0}}, 1.0, 0.1));
  all.add(row(only(Source::motor), {{of::speed, 1.0}}, 2.0, 0.2));
  const Solution solution = all.without(0);
  EXPECT_NEAR(solution.motion[of::speed], 1.2, 1e-9);
  EXPECT_NEAR(solution.sigma[of::speed], std::sqrt(1.0 / 125.0), 1e-9);
  EXPECT_NEAR(solution.misfit, 1.0 / (0.01 + 0.04), 1e-6);
}

TEST(Consensus, LeavingOutTheOneThatIsWrongExplainsItAndAnotherDoesNot) {
  Consensus all = with_weak_priors();
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
  Consensus all = with_weak_priors();
  all.add(row(only(Source::steering) | only(Source::motor), {{of::yaw_rate, 1.0}}, 2.0, 0.1));
  EXPECT_NEAR(all.without(0).motion[of::yaw_rate], 2.0, 1e-6);
  EXPECT_NEAR(all.without(only(Source::motor)).motion[of::yaw_rate], 0.0, 1e-6);
  EXPECT_NEAR(all.without(only(Source::yaw_rate)).motion[of::yaw_rate], 2.0, 1e-6);
}

TEST(Consensus, IgnoresRowsBeyondItsCapacity) {
  Consensus all = with_weak_priors();
  for (std::size_t i = 0; i < 2 * Consensus::capacity; ++i)
    all.add(row(only(Source::motor), {{of::speed, 1.0}}, 1.0, 0.1));
  EXPECT_EQ(static_cast<std::size_t>(all.end() - all.begin()), Consensus::capacity);
  EXPECT_NEAR(all.without(0).motion[of::speed], 1.0, 1e-6);
}

}  // namespace
}  // namespace odomd::estimator::integrity::equations_test
