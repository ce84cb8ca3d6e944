// Noise that is estimated from a sensor's scatter and from the innovations, and the bounds of both.
#include "estimator/ekf/judge.hpp"

#include <random>

#include "estimator/ekf/measurement_models.hpp"
#include "estimator/ekf/take.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::full::noise_test {
namespace {

constexpr double stated = 0.03;

/// The final sigma of a sensor that scatters by `scatter` stated sigmas about `signal`, a function
/// of the sample's number.
template <typename Signal>
double used(State& state, Source source, bool still, double scatter, const Signal& signal,
            int samples = 2000) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  state.standstill.wheels_still = still;
  double sigma = 0.0;
  for (int i = 0; i < samples; ++i) {
    Sample sample{.source = source, .sigma = {stated}};
    sample.value[0] = signal(i) + scatter * stated * normal(random);
    measure_noise({}, state, sample);
    sigma = sample.sigma[0] / stated;
  }
  return sigma;
}

constexpr auto nothing = [](int) { return 0.0; };

TEST(MeasuredNoise, IsTheScatterOfTheSamplesWithinBounds) {
  struct Case {
    Source source;
    bool still;
    double scatter;
    double expected;
    double tolerance = 1e-12;
  };
  for (const Case& c : {Case{Source::yaw_rate, true, 0.15, 0.15, 0.0225},
                        {Source::yaw_rate, true, 0.5, 0.5, 0.075},
                        {Source::yaw_rate, true, 0.9, 0.9, 0.135},
                        {Source::accel_x, false, 0.5, 0.5, 0.075},
                        {Source::accel_x, false, 1.0, 1.0, 0.15},
                        {Source::accel_x, false, 2.5, 2.5, 0.375},
                        {Source::yaw_rate, true, 0.0, 0.1},
                        {Source::yaw_rate, true, 20.0, 1.0},
                        {Source::yaw_rate, false, 0.0, std::sqrt(0.1)},
                        {Source::yaw_rate, false, 20.0, std::sqrt(10.0)},
                        {Source::accel_y, true, 20.0, 1.0},
                        {Source::accel_y, false, 0.0, std::sqrt(0.1)},
                        {Source::accel_y, false, 20.0, std::sqrt(10.0)}}) {
    State state;
    EXPECT_NEAR(used(state, c.source, c.still, c.scatter, nothing), c.expected, c.tolerance)
        << source_names[index_of(c.source)] << ' ' << c.still << ' ' << c.scatter;
  }
}

TEST(MeasuredNoise, AtRestAndMovingAreSeparate) {
  State state;
  EXPECT_NEAR(used(state, Source::accel_x, true, 0.2, nothing), 0.2, 0.03);
  EXPECT_NEAR(used(state, Source::accel_x, false, 2.0, nothing), 2.0, 0.3);
  // At rest the old value is back immediately.
  EXPECT_NEAR(used(state, Source::accel_x, true, 0.2, nothing, 5), 0.2, 0.03);
}

TEST(MeasuredNoise, MotionHardlyAffectsIt) {
  State state;
  // An amplitude of 2 sigmas, three times a second, sampled every 5 ms
  const auto weave = [](int i) { return 2.0 * std::sin(20.0 * 0.005 * i) * stated; };
  EXPECT_NEAR(used(state, Source::accel_y, false, 1.0, weave), 1.0, 0.1);
  const auto ramp = [](int i) { return 5.0 * i * stated; };
  State other;
  EXPECT_NEAR(used(other, Source::accel_y, false, 1.0, ramp), 1.0, 0.1);
}

TEST(MeasuredNoise, IsTheStatedOneUntilThereAreSamples) {
  State state;
  EXPECT_EQ(used(state, Source::yaw_rate, true, 0.0, nothing, 5), 1.0);
}

TEST(NoiseOf, IsTheSigmaThatIsUsed) {
  const Tuning t;
  for (const Source source : {Source::yaw_rate, Source::accel_x, Source::accel_y}) {
    State state;
    // Six samples make four second differences.
    (void)used(state, source, true, 0.2, nothing, 6);
    EXPECT_FALSE(noise_of(t, state, source, stated).estimated());
    const double at_rest = stated * used(state, source, true, 0.2, nothing);
    EXPECT_DOUBLE_EQ(noise_of(t, state, source, stated).at_rest, at_rest);
    EXPECT_EQ(noise_of(t, state, source, stated).moving, 0.0);
    const double moving = stated * used(state, source, false, 20.0, nothing);
    const SourceNoise noise = noise_of(t, state, source, stated);
    EXPECT_EQ(noise.stated, stated);
    EXPECT_DOUBLE_EQ(noise.at_rest, at_rest);
    EXPECT_DOUBLE_EQ(noise.moving, moving);
    EXPECT_EQ(noise.speed_share, 0.0);
    EXPECT_NEAR(noise.moving, std::sqrt(10.0) * stated, 1e-12);
  }
}

TEST(NoiseOf, OfAWheelIsAShareOfItsSpeed) {
  Tuning t;
  t.wheel_radius = 0.004;
  constexpr Source wheel = Source::wheel_front_left;
  State state;
  state.reading(wheel).noise_scale = 9.0;
  EXPECT_FALSE(noise_of(t, state, wheel, stated).estimated()) << "no sample yet";
  state.reading(wheel).consistent = 1;
  EXPECT_DOUBLE_EQ(noise_of(t, state, wheel, stated).speed_share, 0.012);
  EXPECT_EQ(noise_of(t, state, wheel, stated).moving, 0.0);
  // predict_wheel_speed() adds the square of this share of the speed to the sensor's variance.
  state.mean[at::v_x] = 2.0;
  const auto variance = [&](double wheel_radius) {
    CarModel model;
    model.tuning.wheel_radius = wheel_radius;
    return predict_wheel_speed(model, {0.0, true}, state, wheel, stated, true).variance;
  };
  EXPECT_NEAR(variance(t.wheel_radius) - variance(0.0), 0.024 * 0.024, 1e-12);
}

TEST(NoiseOf, IsNotEstimatedForInputsAndCamera) {
  State state;
  for (const Source source : {Source::steering, Source::direction, Source::camera}) {
    state.reading(source).consistent = 3;
    EXPECT_FALSE(noise_of({}, state, source, stated).estimated());
  }
}

/// An innovation with a variance of 4, of which a part is the sample's, and a part of that the
/// wheel's own relative error.
void adapt(State& state, Source source, double innovation, double of_sample, double relative) {
  Prediction z;
  z.variance = 4.0 * of_sample;
  z.relative = 4.0 * relative;
  Innovation nu;
  nu.value = innovation;
  nu.variance_of_noise = nu.variance = 4.0;
  adapt_noise_scales({}, state, {.source = source}, z, nu);
}

/// The state after 100 s with 100 innovations of `sigmas` per second; `share`: the part of the
/// variance from the wheel's own relative error, the rest being the state's.
State surprised(Source source, double sigmas, double share, State state = {}) {
  state.reading(source).interval_s = 0.01;
  for (int i = 0; i < 10'000; ++i)
    adapt(state, source, 2.0 * sigmas * (i % 2 == 0 ? 1.0 : -1.0), share, share);
  return state;
}

TEST(NoiseScale, GrowsAndShrinksToItsBoundsWithTheInnovations) {
  const Tuning t;
  constexpr Source wheel = Source::wheel_rear_left;
  const State restless = surprised(wheel, 3.0, 0.5);
  EXPECT_EQ(restless.drive_noise_scale, t.drive_noise_scale_range);
  EXPECT_EQ(restless.reading(wheel).noise_scale, t.wheel_noise_scale_range);
  EXPECT_EQ(restless.reading(Source::wheel_rear_right).noise_scale, 1.0);
  EXPECT_EQ(restless.turn_noise_scale, 1.0);
  const State calm = surprised(wheel, 0.1, 0.5, restless);
  EXPECT_EQ(calm.drive_noise_scale, 1.0 / t.drive_noise_scale_range);
  EXPECT_EQ(calm.reading(wheel).noise_scale, 1.0 / t.wheel_noise_scale_range);

  const State straight = surprised(Source::yaw_rate, 0.1, 0.5);
  EXPECT_EQ(straight.turn_noise_scale, 1.0 / t.turn_noise_scale_range);
  EXPECT_EQ(straight.drive_noise_scale, 1.0);
  EXPECT_EQ(surprised(Source::yaw_rate, 3.0, 0.5, straight).turn_noise_scale, 1.0);
}

TEST(NoiseScale, StaysIfTheInnovationsAreAsExpected) {
  const State state = surprised(Source::wheel_rear_left, 1.0, 0.5);
  EXPECT_NEAR(state.drive_noise_scale, 1.0, 1e-9);
  EXPECT_NEAR(state.reading(Source::wheel_rear_left).noise_scale, 1.0, 1e-9);
}

TEST(NoiseScale, ASampleWithoutInformationChangesNothing) {
  // If all of S is the wheel's own noise, the sample says nothing about a_x; if none of S is, it
  // says nothing about the wheel.
  EXPECT_EQ(surprised(Source::wheel_rear_left, 3.0, 1.0).drive_noise_scale, 1.0);
  EXPECT_EQ(
      surprised(Source::wheel_rear_left, 3.0, 0.0).reading(Source::wheel_rear_left).noise_scale,
      1.0);
  // The part of S from a wheel's stated sigma does not adapt its relative error.
  State state;
  state.reading(Source::wheel_rear_left).interval_s = 0.01;
  adapt(state, Source::wheel_rear_left, 0.0, 0.5, 0.0);
  EXPECT_EQ(state.reading(Source::wheel_rear_left).noise_scale, 1.0);
  EXPECT_LT(state.drive_noise_scale, 1.0);
  // A sample at standstill adapts nothing, either.
  State standing;
  standing.standstill.standing = true;
  EXPECT_EQ(surprised(Source::wheel_rear_left, 3.0, 0.5, standing).drive_noise_scale, 1.0);
  EXPECT_EQ(surprised(Source::yaw_rate, 0.1, 0.5, standing).turn_noise_scale, 1.0);
}

TEST(NoiseScale, AnOutlierChangesItLittle) {
  State state;
  state.reading(Source::wheel_rear_left).interval_s = 1.0;
  adapt(state, Source::wheel_rear_left, 2e6, 0.5, 0.5);
  EXPECT_LT(state.drive_noise_scale, 1.5);
  EXPECT_LT(state.reading(Source::wheel_rear_left).noise_scale, 1.5);
}

TEST(NoiseScale, OfThePositionFollowsTheCamera) {
  const Tuning t;
  State state;
  for (int i = 0; i < 5000; ++i) adapt_way_noise_scale(t, state, 12.0, 0.035);
  EXPECT_EQ(state.way_noise_scale, t.way_noise_scale_range);
  for (int i = 0; i < 5000; ++i) adapt_way_noise_scale(t, state, 1.0, 0.035);
  EXPECT_EQ(state.way_noise_scale, 1.0);
  adapt_way_noise_scale(t, state, 3.0, 0.035);  // as expected of three degrees of freedom
  EXPECT_EQ(state.way_noise_scale, 1.0);
}

TEST(CameraNoise, IsNotLearntAcrossAPause) {
  State state;
  for (int i = 0; i < 200; ++i) {
    state.time_ns += i % 2 == 0 ? 1'000'000'000 : 35'000'000;
    state.mean[at::x] = i % 4 < 2 ? 0.2 : -0.2;  // the filter's error by then
    note_camera_pose(state, {.time_ns = state.time_ns, .sigma = {0.01, 0.01, 0.01}});
  }
  EXPECT_EQ(state.camera_noise_scale, 1.0);
}

}  // namespace
}  // namespace odomd::estimator::full::noise_test
