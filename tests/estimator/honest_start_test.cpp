// One sensor alone decides nothing: not at the start, not at rest, not at a single instant.
#include <random>
#include <tuple>

#include "tests/estimator/circle_drive.hpp"
#include "tests/estimator/signalled_car.hpp"

namespace odomd::estimator::full::testing::honest_start_test {
namespace {

using estimator::testing::Arrival;
using estimator::testing::drive_on_a_circle;
using estimator::testing::on_circle;
using estimator::testing::run;

TEST(HonestStart, GarbageInTheFirstSamplesDoesNotMoveAStandingCar) {
  for (const Source source : {Source::wheel_front_left, Source::wheel_rear_right, Source::yaw_rate,
                              Source::accel_x, Source::steering}) {
    for (const double value : {-20.0, 0.5, 20.0, 140.0}) {
      const double limit = 0.9 * physical_limit[index_of(source)];
      const double garbage = std::clamp(value, -limit, limit);
      for (const int burst : {1, 2}) {
        Car car;
        car.push(source, garbage);
        if (burst == 2) {
          advance(car.context, car.state, car.state.time_ns + period_ns);
          car.push(source, garbage);
        }
        car.drive(3.0, straight_at(0.0));
        SCOPED_TRACE(::testing::Message()
                     << source_names[index_of(source)] << ' ' << garbage << ", " << burst);
        EXPECT_LT(std::hypot(car.x(), car.state.mean[at::y]), 0.05);
        EXPECT_NEAR(car.v_x(), 0.0, 0.01);
        EXPECT_TRUE(car.stands());
      }
    }
  }
}

TEST(HonestStart, TheFirstReadingAfterAGapDoesNotTurnTheCar) {
  for (const double gap_s : {0.1, 0.3, 0.9, 1.2}) {
    for (const double garbage : {-30.0, 2.0, 5.0, 30.0}) {
      for (const bool known : {true, false}) {  // false: it is the first reading of all
        Car car;
        const SensorValues straight = straight_at(1.5);
        const SensorValues silent = without(straight, Source::yaw_rate);
        car.drive(2.0, known ? straight : silent);
        car.drive(gap_s, silent);
        car.push(Source::yaw_rate, garbage);
        car.drive(1.0, straight);
        EXPECT_NEAR(car.yaw(), 0.0, 0.02) << garbage << " after " << gap_s << ' ' << known;
      }
    }
  }
}

TEST(HonestStart, ASlowGyroIsUsed) {
  Car car = car_at_rest(1.0);
  const SensorValues bend = bend_at(1.5, 0.4);
  for (int i = 0; i < 20; ++i) {
    car.drive(0.3, without(bend, Source::yaw_rate, Source::steering));
    car.push(Source::yaw_rate, 0.4);
  }
  EXPECT_EQ(car.state.reading(Source::yaw_rate).fused_ns, car.state.time_ns);
}

// In a reversal, or before the wheels turn, the gyro measures `turn` while the wheels read 0.
TEST(HonestStart, AShortHaltDoesNotRewriteTheBias) {
  for (const double turn : {-1.0, 0.1, 0.3, 1.5}) {
    for (const double halt_s : {0.1, 0.3, 0.5}) {
      Car car = car_after(2.0, bend_at(1.0, turn));
      car.drive(halt_s, with(straight_at(0.0, -2.0), Source::yaw_rate, turn));
      car.drive(1.0, bend_at(1.0, turn));
      EXPECT_LT(std::abs(car.gyro_bias()), 0.02) << turn << ' ' << halt_s;
    }
  }
}

TEST(HonestStart, ADepartureIsNotABias) {
  // Late wheels still read 0 while the car turns.
  for (const double late_s : {0.1, 0.2}) {
    Car car = car_at_rest(1.5);
    car.drive(late_s,
              [](double t) { return with(straight_at(0.0, 2.0), Source::yaw_rate, 2.0 * t); });
    car.drive(1.0, bend_at(1.0, 0.4));
    EXPECT_LT(std::abs(car.gyro_bias()), 0.005) << late_s;
  }
}

/// Rms distance from the truth [m] and number of doubtful ticks, over the last five of ten seconds
/// on the circle, with `looks` camera poses per picture, spaced by `apart` nanoseconds.
std::tuple<double, int> after_looks(int looks, std::int64_t apart, double stated) {
  estimator::testing::Recording drive{.random = std::mt19937(3)};
  for (const Arrival& arrival : drive_on_a_circle(10'000 * millisecond)) {
    if (!arrival.camera) {
      drive.arrivals.push_back(arrival);
      continue;
    }
    for (int look = 0; look < looks; ++look) {
      const std::int64_t capture_ns = arrival.camera->capture_ns + look * apart;
      drive.see(capture_ns, on_circle(capture_ns), stated);
    }
  }
  double squares = 0.0;
  int doubtful = 0;
  const std::vector<Estimate> estimates = run(drive.in_order(), 2000);
  for (std::size_t i = 1000; i < estimates.size(); ++i) {
    const Estimate& e = estimates[i];
    const Pose2 truth = on_circle(e.time_ns);
    squares += std::pow(e.map.x - truth.x, 2) + std::pow(e.map.y - truth.y, 2);
    doubtful += e.doubtful ? 1 : 0;
  }
  return {std::sqrt(squares / static_cast<double>(estimates.size() - 1000)), doubtful};
}

TEST(HonestStart, TwoPosesThatAgreeLocateTheCar) {
  State state = initial_state({});
  state.moving = true;
  const std::array poses{Pose2{10.0, -5.0, 2.0}, Pose2{1.0, 2.0, 0.5}, Pose2{1.01, 2.0, 0.5}};
  for (std::size_t i = 0; i < poses.size(); ++i) {
    state.time_ns = static_cast<std::int64_t>(i + 1) * 35 * millisecond;
    const Sample seen{.time_ns = state.time_ns,
                      .source = Source::camera,
                      .value = {poses[i].x, poses[i].y, poses[i].yaw},
                      .sigma = {0.01, 0.01, 0.01}};
    const Judgement judgement = take_camera(CarModel{}, {}, state, {}, seen);
    EXPECT_EQ(judgement.verdict, i == 1 ? Verdict::forced : Verdict::fused) << i;
    EXPECT_EQ(judgement.degrees, i == 2 ? 3 : 0) << i;  // others do not test the filter
    EXPECT_NEAR(state.mean[at::x], poses[i].x, 0.01) << i;
    const bool confirmed = i + 1 == poses.size();
    EXPECT_EQ(state.unconfirmed, !confirmed) << i;
    const Estimate e = publication({}, {}, 0.005, state, initial_state({}));
    EXPECT_EQ(std::sqrt(e.covariance[0]) < 0.02, confirmed) << i;
  }
  EXPECT_FALSE(state.doubtful);
  EXPECT_EQ(state.disputed.head<2>().squaredNorm(), 0.0);
}

TEST(HonestStart, SimultaneousPosesAreAllUsed) {
  const double one = std::get<0>(after_looks(1, 0, 1.0));
  for (const int looks : {2, 3, 5}) {
    for (const std::int64_t apart : {std::int64_t{0}, std::int64_t{1'000}, millisecond / 2}) {
      const auto [error, doubtful] = after_looks(looks, apart, 1.0);
      EXPECT_LT(error, 1.1 * one) << looks << ' ' << apart;
      EXPECT_EQ(doubtful, 0) << looks << ' ' << apart;
    }
  }
}

TEST(HonestStart, ACameraIsWeightedByItsScatter) {
  for (const double stated : {1.0 / 30.0, 1.0 / 80.0, 1.0 / 1000.0}) {
    const auto [error, doubtful] = after_looks(1, 0, stated);
    EXPECT_LT(error, 0.012) << stated;
  }
}

/// A full-size car creeps on a circle with wheels that read 0; camera, gyro and steering are right.
TEST(HonestStart, WheelsThatAreBlindToACreepDoNotBeatACameraThatSeesIt) {
  for (const double speed : {0.3, 0.5, 0.7}) {
    FilterSettings settings;
    settings.vehicle.front_axle = 1.25;
    settings.vehicle.rear_axle = 1.45;
    settings.vehicle.mass = 1700.0;
    settings.vehicle.yaw_inertia = 2800.0;
    settings.vehicle.cornering_stiffness_front = 110000.0;
    settings.vehicle.cornering_stiffness_rear = 135000.0;
    settings.vehicle.track_width = 1.58;
    estimator::testing::Drive car = estimator::testing::start(Model::full, settings);
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    double off = 0.0;
    int beyond = 0;  // ticks with an error above four sigmas: the departure is unnoticed
    for (int k = 1; k <= 4000; ++k) {
      const double t = std::max(k * 0.005 - 3.0, 0.0);
      const double v = std::min(t, speed);
      const double turn = v / 40.0;
      const double way = v < speed ? 0.5 * t * t : speed * (t - 0.5 * speed);
      const Pose2 truth = moved({}, {way, 0.0, way / 40.0}, 1.0);
      car.send(Source::yaw_rate, turn + 0.002 * normal(random), 0.002);
      car.send(Source::steering, 2.7 / 40.0, 0.001);
      for (const Source wheel : all_sources)
        if (k % 2 == 0 && is_single_wheel(wheel)) car.send(wheel, 0.0, 0.014);
      if (k % 7 == 0) {
        car.see({truth.x + 0.08 * normal(random), truth.y + 0.08 * normal(random),
                 truth.yaw + 0.009 * normal(random)},
                0.08, 0.009);
      }
      const Estimate e = car.tick();
      off = std::hypot(e.map.x - truth.x, e.map.y - truth.y);
      beyond += off > 4.0 * std::sqrt(e.covariance[0] + e.covariance[3]) ? 1 : 0;
    }
    EXPECT_LT(off, 0.3) << speed;
    EXPECT_LT(beyond, 240) << speed;  // of 4000
  }
}

}  // namespace
}  // namespace odomd::estimator::full::testing::honest_start_test
