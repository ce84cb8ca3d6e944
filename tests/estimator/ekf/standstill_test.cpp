// Start and end of a standstill, and the estimates during one.
#include "estimator/ekf/standstill.hpp"

#include <random>

#include "estimator/ekf/publication.hpp"
#include "estimator/ekf/take.hpp"
#include "estimator/ekf/update.hpp"
#include "tests/estimator/signalled_car.hpp"

namespace odomd::estimator::full::testing::standstill_test {
namespace {

constexpr double wheel_sigma = 0.01;
constexpr double gyro_sigma = 0.005;

State just_stopped() {
  State state;
  state.time_ns = 1'000 * millisecond;
  state.located = true;
  state.moving = true;
  state.mean[at::v_x] = 0.01;
  state.mean[at::yaw_rate] = 0.02;
  state.mean[at::front_angle] = 0.3;
  state.covariance = some_covariance(1e-3);
  state.slow = some_slow_errors(1e-3);
  state.slow.mean.setZero();
  state.standstill.dead_band.fill(0.02);
  return state;
}

/// Sends wheel and gyro samples every 10 ms until the car stands, or for `duration_ms`; returns how
/// long that took [ms].
template <typename Wheel, typename Gyro>
std::int64_t time_to_stand(State& state, std::int64_t duration_ms, const Wheel& wheel,
                           const Gyro& gyro) {
  const CarModel model;
  const std::int64_t begin_ns = state.time_ns;
  for (std::int64_t ms = 0; ms <= duration_ms; ms += 10) {
    state.time_ns = begin_ns + ms * millisecond;
    const Sample turn{.time_ns = state.time_ns,
                      .source = Source::yaw_rate,
                      .value = {gyro(ms)},
                      .sigma = {gyro_sigma}};
    const Sample speed{.time_ns = state.time_ns,
                       .source = Source::wheel_rear,
                       .value = {wheel(ms)},
                       .sigma = {wheel_sigma}};
    state.integrity.add(turn.source, turn.time_ns, turn.value[0], gyro_sigma);
    note_reading(state, turn);
    state.note_fused(speed.source, speed.time_ns);
    note_wheels(state, speed, !is_turning(wheel(ms), wheel_sigma));
    update_standstill(model, state, turn);
    if (state.standstill.standing) return ms;
  }
  return -1;
}

constexpr auto zero = [](std::int64_t) { return 0.0; };

TEST(Standstill, AHaltDoesNotMoveThePose) {
  // After a long drive the errors of velocity and pose are correlated.
  State state = just_stopped();
  state.slow.sensitivity.topRows<3>().array() += 100.0;
  const Eigen::Vector3d before = state.mean.head<3>();
  ASSERT_GE(time_to_stand(state, 1000, zero, [](std::int64_t) { return 0.02; }), 0);
  EXPECT_EQ(state.mean.head<3>(), before);
  EXPECT_TRUE(is_covariance(state.covariance));
}

TEST(Standstill, BeginsWhenNoWheelHasTurnedForLongEnough) {
  State state = just_stopped();
  EXPECT_NEAR(static_cast<double>(time_to_stand(state, 1000, zero, zero)), 230.0, 90.0);
  for (const at::Index still : {at::v_x, at::v_y, at::yaw_rate, at::front_angle})
    EXPECT_EQ(state.mean[still], 0.0) << still;
  EXPECT_LT(std::sqrt(state.variance(at::v_x)), 2e-4);
  EXPECT_TRUE(is_covariance(state.covariance));
}

TEST(Standstill, BeginsFromWheelsAndGyro) {
  using Reading = double (*)(std::int64_t ms);
  struct Case {
    const char* name;
    Reading wheel;
    Reading gyro;
    double earliest_ms;
    double latest_ms;
    double dead_band = 0.02;
  };
  for (const Case& c : {
           Case{"noise of the wheels",
                [](std::int64_t ms) { return ms % 20 == 0 ? 0.009 : -0.009; }, zero, 140.0, 320.0},
           {"a turn of a wheel starts it again",
            [](std::int64_t ms) { return ms == 110 ? 0.1 : 0.0; }, zero, 250.0, 430.0},
           {"not while the gyro swings", zero,
            [](std::int64_t ms) { return 0.3 * std::sin(0.01 * static_cast<double>(ms)); }, -1.0,
            -1.0},
           {"a bias of the gyro is no turn", zero, [](std::int64_t) { return 0.05; }, 1.0, 900.0},
           {"wheels that are blind to slow speeds", zero, zero, 600.0, 5000.0, 0.8},
       }) {
    State state = just_stopped();
    state.standstill.dead_band.fill(c.dead_band);
    const std::int64_t longest_ms = c.latest_ms < 0.0 ? 900 : 5000;
    const auto ms = static_cast<double>(time_to_stand(state, longest_ms, c.wheel, c.gyro));
    EXPECT_GE(ms, c.earliest_ms) << c.name;
    EXPECT_LE(ms, c.latest_ms) << c.name;
  }
}

TEST(Standstill, ANoisySensorDoesNotHideCreeping) {
  EXPECT_TRUE(is_turning(0.05, 1.0));
  EXPECT_TRUE(is_turning(-0.05, 1.0));
}

TEST(Standstill, IsOverWhenTheCarSetsOff) {
  State state = just_stopped();
  ASSERT_GT(time_to_stand(state, 1000, zero, zero), 0);
  set_off({}, state, -0.2);
  EXPECT_EQ(state.standstill.dead_band[index_of(Source::wheel_rear)], 0.02);
  EXPECT_FALSE(state.standstill.standing);
  EXPECT_FALSE(state.standstill.wheels_still);
  EXPECT_NEAR(std::sqrt(state.variance(at::v_x)), 0.2, 1e-12);
  for (const at::Index unknown : {at::v_y, at::yaw_rate})
    EXPECT_GT(std::sqrt(state.variance(unknown)), 0.01);
  EXPECT_TRUE(is_covariance(state.covariance));
}

TEST(Standstill, TheDeadBandMayBeConfigured) {
  FilterSettings settings;
  settings.dead_band[index_of(Source::wheel_rear)] = 0.3;
  EXPECT_EQ(initial_state(settings).standstill.dead_band[index_of(Source::wheel_rear)], 0.3);
}

TEST(Standstill, ABlindWheelShowsItsDeadBand) {
  State state = just_stopped();
  state.standstill.dead_band.fill(0.8);
  const auto reads = [&state](double speed) {
    state.time_ns += 10 * millisecond;
    const Sample sample{.time_ns = state.time_ns,
                        .source = Source::wheel_rear_left,
                        .value = {speed},
                        .sigma = {wheel_sigma}};
    learn_dead_band(state, sample);
    note_reading(state, sample);
  };
  state.standstill.wheels_still = true;
  for (const double speed : {0.3, 0.25, 0.0})  // one wheel trembles while the others stand
    reads(speed);
  state.standstill.wheels_still = false;
  for (const double speed : {0.9, 0.85, 0.0, 0.0}) reads(speed);
  EXPECT_EQ(state.standstill.dead_band[index_of(Source::wheel_rear_left)], 0.8);
  for (const double speed : {0.3, 0.0, 0.25, 0.2})  // a single reading may be a corrupt frame
    reads(speed);
  EXPECT_EQ(state.standstill.dead_band[index_of(Source::wheel_rear_left)], 0.25);
}

/// The sensors of a car that stands, with their biases.
SensorValues biased_at_rest() {
  return {{Source::yaw_rate, 0.013},
          {Source::accel_x, 0.2},
          {Source::accel_y, -0.15},
          {Source::wheel_rear_left, 0.0},
          {Source::wheel_rear_right, 0.0}};
}

TEST(Standstill, BiasesAreLearntBeforeTheFirstMove) {
  const State before = Car{}.state;
  Car car = car_after(3.0, biased_at_rest());
  EXPECT_TRUE(car.gated.empty());
  EXPECT_TRUE(car.stands());
  EXPECT_NEAR(car.gyro_bias(), 0.013, 1e-3);
  EXPECT_NEAR(car.state.mean[at::accel_bias_x], 0.2, 0.02);
  EXPECT_NEAR(car.state.mean[at::accel_bias_y], -0.15, 0.02);
  for (const at::Index bias : {at::accel_bias_x, at::accel_bias_y})
    EXPECT_LT(car.state.variance(bias), 0.1 * before.variance(bias));
  EXPECT_LT(car.state.variance(slow::gyro_bias), 0.1 * before.variance(slow::gyro_bias));
}

TEST(Standstill, TheBiasIsLearntWithTheNoiseAtRest) {
  // The bias's sigma follows the actual scatter (a fifth of the stated noise, or all of it): it is
  // that of a mean over about 1.5 s at 200 samples a second, plus the walk.
  for (const double share : {0.2, 1.0}) {
    const double scatter = share * Car::sigmas[index_of(Source::yaw_rate)];
    std::mt19937 random(3);
    std::normal_distribution<double> reading(0.013, scatter);
    Car car;
    car.drive(2.4, [&](double) {
      return SensorValues{{Source::wheel_rear, 0.0}, {Source::yaw_rate, reading(random)}};
    });
    ASSERT_TRUE(car.stands());
    const double sigma = car.state.sigma(slow::gyro_bias);
    EXPECT_NEAR(sigma, scatter / std::sqrt(300.0), 0.5 * scatter / 17.0);
    EXPECT_LT(std::abs(car.gyro_bias() - 0.013), 3.0 * sigma);
  }
}

TEST(Standstill, NothingIsCorrelatedWithTheMotionAtStandstill) {
  State state = just_stopped();
  ASSERT_GT(time_to_stand(state, 1000, zero, zero), 0);
  Matrix related = state.covariance;
  for (const at::Index still : {at::v_x, at::v_y, at::yaw_rate, at::accel_x, at::front_angle}) {
    related(still, still) = 0.0;
    EXPECT_TRUE(related.row(still).isZero(0.0)) << still;
    EXPECT_TRUE(state.slow.sensitivity.row(still).isZero(0.0)) << still;
  }
}

TEST(Standstill, HoldsThePoseWithoutBecomingMoreCertain) {
  Car car;
  const auto known = [&car]() -> Eigen::Vector3d {
    return covariance_of_motion(car.state).diagonal().head<3>();
  };
  Eigen::Vector3d variances = known();
  Pose2 before;
  for (int i = 0; i < 6000; ++i) {
    car.tick(biased_at_rest());
    // The variances fall at most by what one step of the corrected velocity explains.
    ASSERT_TRUE((known().array() >= 0.9999 * variances.array()).all()) << i;
    if (i == 200) {
      variances = known();
      before = car.state.pose();
      ASSERT_TRUE(car.stands());
    }
  }
  EXPECT_TRUE(car.stands());
  EXPECT_TRUE(car.gated.empty());
  EXPECT_THAT(car.state.pose(), estimator::testing::PoseNear(before, 1e-6));
  EXPECT_NEAR(car.v_x(), 0.0, 1e-6);
}

}  // namespace
}  // namespace odomd::estimator::full::testing::standstill_test
