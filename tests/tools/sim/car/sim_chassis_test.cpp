// Cars with published data, compared with theory: roll and pitch of the body, wheel loads, driven
// wheels, and sensor readings on the body.
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "tests/tools/sim/car/ideal_car.hpp"
#include "tools/sim/course/track.hpp"

namespace odomd::sim::sim_chassis_test {
namespace {

constexpr double dt = plant_dt;

constexpr double gravity = 9.80665;
constexpr double degree = std::numbers::pi / 180.0;

Plant steady(const PlantParameters& car, double speed, double steering, const RoadTilt& road = {}) {
  return sim::steady(car, speed, steering, 8.0, 4.0, road);
}

double sum(const std::array<double, wheel_count>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

class PublishedCar : public ::testing::TestWithParam<CarKind> {
 protected:
  const PlantParameters car = ideal_car(GetParam());
};

INSTANTIATE_TEST_SUITE_P(Sim, PublishedCar,
                         ::testing::Values(CarKind::bmw_320i, CarKind::ford_escort,
                                           CarKind::vw_vanagon),
                         [](const auto& car) { return std::string(car_name(car.param)); });

/// Adds the saloon, whose body is rigid.
class AnyCar : public PublishedCar {};

INSTANTIATE_TEST_SUITE_P(Sim, AnyCar,
                         ::testing::Values(CarKind::saloon, CarKind::bmw_320i, CarKind::ford_escort,
                                           CarKind::vw_vanagon),
                         [](const auto& car) { return std::string(car_name(car.param)); });

TEST_P(PublishedCar, RollsInASteadyTurnAsItsGradientSays) {
  for (const double steering : {0.06, -0.06}) {
    const PlantOutput out = steady(car, 10.0, steering).output();
    EXPECT_GT(std::abs(out.accel_y), 1.5);
    EXPECT_NEAR(out.roll, car.suspension.roll_gradient() * out.accel_y, 0.01 * std::abs(out.roll));
    EXPECT_NEAR(out.roll_rate, 0.0, 1e-4);
    // The body leans outwards, so gravity adds to the lateral accelerometer's reading.
    EXPECT_EQ(std::signbit(out.roll), std::signbit(out.accel_y));
    const double read = specific_force_at(out, 0.0, 0.0).y;
    EXPECT_NEAR(read / out.accel_y, 1.0 + gravity * car.suspension.roll_gradient(), 0.01);
  }
}

TEST_P(PublishedCar, RollsAndPitchesLikeRealCars) {
  const double per_g = gravity / degree;
  EXPECT_NEAR(car.suspension.roll_gradient() * per_g, 7.5, 1.5);
  EXPECT_NEAR(
      ideal_car(GetParam(), {{Parameter::roll_stiffness, 2.5}}).suspension.roll_gradient() * per_g,
      3.0, 1.0);
  EXPECT_NEAR(car.suspension.pitch_gradient() * per_g, 3.0, 0.5);
}

TEST_P(PublishedCar, DivesUnderTheBrakesAndSwingsOut) {
  Plant plant(car, 0.0, 0.0, 0.0);
  plant.set_speed(20.0);
  drive(plant, {.force = -3.0 * car.mass}, 2.0);
  const PlantOutput braking = plant.output();
  EXPECT_GT(braking.pitch, 0.0);  // nose down
  EXPECT_NEAR(braking.pitch, -car.suspension.pitch_gradient() * braking.accel_x,
              0.03 * braking.pitch);
  // When the car has stopped, the body swings back and becomes level.
  double highest = 0.0;
  for (int k = 0; k < 50'000; ++k) {
    plant.step({.force = -car.mass * std::min(3.0, 4.0 * plant.output().v_x)}, dt);
    highest = std::min(highest, plant.output().pitch);
  }
  EXPECT_LT(highest, 0.0);
  EXPECT_EQ(plant.motion(), Movement::resting);
  EXPECT_NEAR(plant.output().pitch, 0.0, 1e-5);
}

TEST_P(PublishedCar, WheelLoadsAddUpToItsWeight) {
  const Plant turning = steady(car, 12.0, 0.05);
  EXPECT_NEAR(sum(turning.loads()), car.mass * gravity, 1e-6 * car.mass * gravity);
  EXPECT_GT(turning.loads()[front_right], turning.loads()[front_left]);
  EXPECT_GT(turning.loads()[rear_right], turning.loads()[rear_left]);
  // Moments about the ground: m h a_y = Σ ΔF_z w, plus the shift of the leaning body.
  const auto& load = turning.loads();
  const double wide = car.track_width + 0.5 * car.track_difference;
  const double narrow = car.track_width - 0.5 * car.track_difference;
  const double carried = 0.5 * wide * (load[front_right] - load[front_left]) +
                         0.5 * narrow * (load[rear_right] - load[rear_left]);
  const PlantOutput out = turning.output();
  const double moment =
      car.mass * car.centre_height * out.accel_y +
      car.suspension.sprung_mass * car.suspension.sprung_height * gravity * std::sin(out.roll);
  EXPECT_NEAR(carried, moment, 0.01 * moment);

  Plant braking(car, 0.0, 0.0, 0.0);
  braking.set_speed(20.0);
  drive(braking, {.force = -3.0 * car.mass}, 1.5);
  EXPECT_NEAR(sum(braking.loads()), car.mass * gravity, 1e-6 * car.mass * gravity);
  EXPECT_GT(braking.loads()[front_left], 1.1 * Plant(car, 0, 0, 0).loads()[front_left]);
}

TEST_P(PublishedCar, DrivesItsOwnAxle) {
  const bool front = GetParam() == CarKind::ford_escort;
  Plant plant(car, 0.0, 0.0, 0.0);
  drive(plant, {.force = 2.0 * car.mass}, 1.0);
  const auto slip = [&](Wheel wheel) {
    return plant.output().wheel_rate[wheel] * car.wheel_radius[wheel] / plant.output().v_x - 1.0;
  };
  EXPECT_GT(slip(front ? front_left : rear_left), 0.005);
  EXPECT_LT(std::abs(slip(front ? rear_left : front_left)), 0.002);
}

TEST_P(PublishedCar, GainsNoEnergyWithoutDrive) {
  Plant plant = steady(car, 12.0, 0.05);
  drive(plant, {.steering = 0.05}, 0.6);  // lag of the drive
  for (int k = 0; k < 20; ++k) {
    const double before = kinetic_energy(car, plant.output());
    drive(plant, {.steering = 0.05}, 0.2);
    EXPECT_LT(kinetic_energy(car, plant.output()), before);
  }
}

TEST_P(PublishedCar, AFinerStepGivesTheSameCar) {
  const auto drive = [&](double step) {
    Plant plant(car, 0.0, 0.0, 0.0);
    for (int k = 0; k < std::lround(4.0 / step); ++k)
      plant.step({.steering = 0.1 * std::sin(2.0 * k * step), .force = 2500.0}, step);
    return plant.output();
  };
  const PlantOutput coarse = drive(0.0005), fine = drive(0.0001);
  EXPECT_NEAR(coarse.x, fine.x, 2e-4);
  EXPECT_NEAR(coarse.y, fine.y, 2e-4);
  EXPECT_NEAR(coarse.roll, fine.roll, 5e-6);
  EXPECT_GT(std::abs(fine.roll), 1e-3);
}

TEST_P(PublishedCar, StandsStillOnASlope) {
  Plant plant(car, 0.0, 0.0, 0.0);
  const RoadTilt road{.grade = 0.05, .bank = -0.07};
  drive(plant, {.road = road}, 10.0);
  EXPECT_EQ(plant.output().x, 0.0);
  EXPECT_EQ(plant.output().v_x, 0.0);
  EXPECT_LT(plant.output().roll, 0.0);   // towards the lower side, the left one
  EXPECT_LT(plant.output().pitch, 0.0);  // onto the rear axle
  const Vector2 specific_force = specific_force_at(plant.output(), 0.0, 0.0);
  const double roll = -0.07 + plant.output().roll, pitch = plant.output().pitch - 0.05;
  EXPECT_NEAR(specific_force.x, -gravity * std::sin(pitch), 0.02);
  EXPECT_NEAR(specific_force.y, gravity * std::sin(roll), 0.02);
  EXPECT_NEAR(body_yaw_rate(plant.output()), 0.0, 1e-9);
}

// Specific force at a point of the body, compared with differences of that point's motion.
TEST_P(AnyCar, SpecificForceMatchesTheMotionOfTheBody) {
  constexpr std::array at{0.35, 0.8, 0.45};
  const auto rotated = [](const PlantOutput& o, std::array<double, 3> v, double sign) {
    // R_z(ψ) R_y(θ) R_x(φ) v, or the inverse
    const auto turn = [](double& a, double& b, double angle) {
      const double c = std::cos(angle), s = std::sin(angle), x = a;
      a = c * x - s * b;
      b = s * x + c * b;
    };
    if (sign > 0) {
      turn(v[1], v[2], o.roll);
      turn(v[2], v[0], o.pitch);
      turn(v[0], v[1], o.yaw);
    } else {
      turn(v[0], v[1], -o.yaw);
      turn(v[2], v[0], -o.pitch);
      turn(v[1], v[2], -o.roll);
    }
    return v;
  };
  const auto place = [&](const PlantOutput& o) {
    std::array<double, 3> p = rotated(o, at, 1.0);
    p[0] += o.x;
    p[1] += o.y;
    return p;
  };
  Plant plant = steady(car, 12.0, 0.0);
  double largest = 0.0;
  for (int k = 0; k < 3'000; ++k) {
    const PlantInput input{.steering = 0.05 * std::sin(4.0 * k * dt),
                           .force = 1500.0 * std::cos(3.0 * k * dt)};
    const PlantOutput a = plant.output();
    for (int i = 0; i < 4; ++i) plant.step(input, dt);
    const PlantOutput b = plant.output();
    for (int i = 0; i < 4; ++i) plant.step(input, dt);
    const PlantOutput c = plant.output();
    std::array<double, 3> force{};
    for (std::size_t i = 0; i < 3; ++i)
      force[i] = (place(c)[i] - 2.0 * place(b)[i] + place(a)[i]) / (16.0 * dt * dt);
    force[2] += gravity;
    const std::array<double, 3> expected = rotated(b, force, -1.0);
    const Vector2 specific_force = specific_force_at(b, at[0], at[1], at[2]);
    ASSERT_NEAR(specific_force.x, expected[0], 0.05);
    ASSERT_NEAR(specific_force.y, expected[1], 0.05);
    largest = std::max(largest, std::abs(specific_force.y));
  }
  EXPECT_GT(largest, 2.0);
}

TEST_P(PublishedCar, TheGyroMeasuresAboutTheAxisOfTheBody) {
  const PlantOutput out = steady(car, 12.0, 0.09).output();
  EXPECT_LT(body_yaw_rate(out), out.yaw_rate);
  EXPECT_NEAR(body_yaw_rate(out), out.yaw_rate * std::cos(out.roll) * std::cos(out.pitch), 1e-4);
}

TEST_P(PublishedCar, ConfiguredStiffnessesAreThoseUnderTheStaticLoad) {
  const estimator::Vehicle owned = configured_vehicle(GetParam());
  const double load = owned.mass * gravity / owned.wheelbase();
  EXPECT_NEAR(owned.cornering_stiffness_front, 21.92 * load * owned.rear_axle, 1000.0);
  EXPECT_NEAR(owned.cornering_stiffness_rear, 21.92 * load * owned.front_axle, 1000.0);
}

TEST(Chassis, UnloadedWheelsDoNotLockOrSpin) {
  const PlantParameters car = ideal_car(CarKind::ford_escort);
  for (const double pedal : {-6.0, 3.0}) {
    Plant plant = steady(car, 14.0, 0.06);
    drive(plant, {.steering = 0.06, .force = pedal * car.mass}, 0.2);
    const PlantOutput& out = plant.output();
    for (std::size_t wheel = 0; wheel < wheel_count; ++wheel)
      EXPECT_NEAR(out.wheel_rate[wheel] * car.wheel_radius[wheel], out.v_x, 0.15 * out.v_x)
          << pedal;
  }
}

TEST(Chassis, ARigidCarStaysLevel) {
  const PlantParameters car = ideal_car(CarKind::saloon);
  EXPECT_FALSE(car.suspension.present());
  const PlantOutput out = steady(car, 10.0, 0.06, {.grade = 0.05}).output();
  EXPECT_TRUE(out.is_level());
  EXPECT_EQ(body_yaw_rate(out), out.yaw_rate);
}

TEST(Road, IsBankedTowardsItsCurvesAndEndsAtItsHeight) {
  std::vector<Vector2> line;
  line.reserve(720);
  for (int k = 0; k < 720; ++k)
    line.push_back({40.0 * std::sin(k * degree / 2.0), 40.0 * (1.0 - std::cos(k * degree / 2.0))});
  const Track track(line, Shape::closed, 8.0);
  const RoadProfile profile{.grade = 0.05, .bank = 4.0 * degree};
  double climbed = 0.0, steepest = 0.0;
  for (int k = 0; k < 10.0 * track.length(); ++k) {
    const double s = 0.1 * k;
    const RoadTilt road = tilt_at(profile, track, s, 10.0);
    EXPECT_NEAR(road.bank, -4.0 * degree, 1e-3);  // to the left: the left side down
    climbed += 0.1 * std::tan(road.grade);
    steepest = std::max(steepest, std::abs(road.grade));
    const double ahead = tilt_at(profile, track, s + 0.1, 10.0).grade;
    const double behind = tilt_at(profile, track, s - 0.1, 10.0).grade;
    EXPECT_NEAR(road.grade_rate, (ahead - behind) / 0.2 * 10.0, 1e-3);
  }
  EXPECT_NEAR(climbed, 0.0, 0.02);
  EXPECT_GT(steepest, 0.03);
  EXPECT_LE(steepest, 0.0501);
  EXPECT_EQ(tilt_at({}, track, 5.0, 10.0).grade, 0.0);
}

TEST(Road, AHillSlowsTheCarThatRollsUp) {
  const PlantParameters car = ideal_car(CarKind::bmw_320i);
  const auto roll = [&car](double grade) {
    Plant plant(car, 0.0, 0.0, 0.0);
    plant.set_speed(15.0);
    drive(plant, {.road = {.grade = grade}}, 2.0);
    return plant.output().v_x;
  };
  EXPECT_NEAR(roll(0.0) - roll(0.05), 2.0 * gravity * std::sin(0.05), 0.08);
}

TEST(Servo, WaitsAndLags) {
  ParameterSet parameters = default_parameters(CarKind::scale_car);
  for (const Assignment& of_servo : slow_servo()) parameters[of_servo.parameter] = of_servo.value;
  const PlantParameters car = true_vehicle(CarKind::scale_car, parameters);
  Plant plant(car, 0.0, 0.0, 0.0);
  const auto after = [&plant](double seconds) {
    drive(plant, {.steering = 0.1}, seconds);
    return plant.output();
  };
  EXPECT_EQ(after(0.06).steering, 0.0);  // dead time
  EXPECT_EQ(plant.output().commanded_steering, 0.1);
  EXPECT_NEAR(after(0.1).steering, 0.1 * (1.0 - std::exp(-1.0)), 1e-3);  // then the lag
  EXPECT_NEAR(after(1.0).steering, 0.1, 1e-4);
}

TEST(Cars, AreFoundByName) {
  EXPECT_EQ(find_car("bmw_320i"), CarKind::bmw_320i);
  EXPECT_EQ(car_name(find_car("vw_vanagon")), "vw_vanagon");
  EXPECT_THROW((void)find_car("fiat"), std::invalid_argument);
}

}  // namespace
}  // namespace odomd::sim::sim_chassis_test
