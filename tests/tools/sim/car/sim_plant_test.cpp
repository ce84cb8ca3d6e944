// The simulated car, compared with theory.
#include "tests/tools/sim/car/ideal_car.hpp"

namespace odomd::sim::sim_plant_test {
namespace {

constexpr double dt = plant_dt;

PlantParameters reference_car(CarKind kind = CarKind::scale_car) {
  return ideal_car(kind);
}

Plant steady(const PlantParameters& car, double speed, double steering, double seconds = 4.0) {
  return sim::steady(car, speed, steering, seconds, 20.0);
}

constexpr Tyre tyre{.cornering_stiffness = 30.0,
                    .slip_stiffness = 90.0,
                    .nominal_load = 10.0,
                    .shape = 1.35,
                    .load_exponent = 0.8};

TEST(Tyre, StartsWithItsStiffnessesAndGrowsLessThanTheLoad) {
  constexpr double slip = 1e-4;
  EXPECT_NEAR(tyre_force(tyre, 10.0, 1.0, 0.0, slip).y / slip, 30.0, 1e-3);
  EXPECT_NEAR(tyre_force(tyre, 10.0, 1.0, slip, 0.0).x / slip, 90.0, 1e-3);
  EXPECT_NEAR(tyre_force(tyre, 10.0, 1.0, 0.0, -slip).y / slip, -30.0, 1e-3);
  const double at_nominal = tyre_force(tyre, 10.0, 1.0, 0.0, 0.01).y;
  const double doubled = tyre_force(tyre, 20.0, 1.0, 0.0, 0.01).y;
  EXPECT_NEAR(doubled / at_nominal, std::pow(2.0, 0.8), 0.01);
  EXPECT_EQ(tyre_force(tyre, 0.0, 1.0, 0.1, 0.1).y, 0.0);
  // A drive force reduces the lateral force.
  const double free = tyre_force(tyre, 10.0, 1.0, 0.0, 0.2).y;
  EXPECT_LT(tyre_force(tyre, 10.0, 1.0, 0.2, 0.2).y, 0.7 * free);
}

TEST(Tyre, NeverExceedsTheFrictionCircleAndFallsBeyondThePeak) {
  double largest = 0.0;
  for (int percent = 0; percent < 300; ++percent) {
    const double slip = 0.01 * percent;
    const Vector2 force = tyre_force(tyre, 10.0, 0.7, 0.5 * slip, slip);
    EXPECT_LE(std::hypot(force.x, force.y), 7.0 + 1e-12);
    largest = std::max(largest, std::hypot(force.x, force.y));
  }
  EXPECT_NEAR(largest, 7.0, 0.01);
  EXPECT_LT(tyre_force(tyre, 10.0, 0.7, 0.0, 3.0).y, 6.9);
}

// ψ̇ = v δ / (l + K v²),  K = (m / l)(l_h / C_v - l_v / C_h),  v_y = ψ̇ (l_h - m l_v v² / (C_h l))
TEST(Plant, TurnsAsTheLinearBicycleDoesWhenDrivenGently) {
  using enum CarKind;
  struct Turn {
    CarKind kind;
    double speed, steering, tolerance;
  };
  for (const auto& [kind, speed, steering, tolerance] : {Turn{scale_car, 0.5, 0.02, 0.03},
                                                         {scale_car, 1.0, -0.02, 0.03},
                                                         {scale_car, 2.0, 0.02, 0.03},
                                                         {bmw_320i, 12.0, 0.01, 0.05},
                                                         {ford_escort, 12.0, 0.01, 0.05},
                                                         {vw_vanagon, 12.0, 0.01, 0.05}}) {
    SCOPED_TRACE(car_name(kind));
    const PlantParameters car = reference_car(kind);
    const double l = car.front_axle + car.rear_axle;
    const PlantOutput out = steady(car, speed, steering, 8.0).output();
    const double K = car.mass / l *
                     (car.rear_axle / car.cornering_stiffness_front -
                      car.front_axle / car.cornering_stiffness_rear);
    EXPECT_GT(K, 0.0);  // understeers
    const double yaw_rate = out.v_x * steering / (l + K * out.v_x * out.v_x);
    EXPECT_NEAR(out.yaw_rate, yaw_rate, 0.02 * std::abs(yaw_rate));
    const double v_y = yaw_rate * (car.rear_axle - car.mass * car.front_axle * out.v_x * out.v_x /
                                                       (car.cornering_stiffness_rear * l));
    EXPECT_NEAR(out.v_y, v_y, tolerance * std::abs(yaw_rate) * car.rear_axle);
  }
}

TEST(Plant, UndersteersMoreThanTheBicycleWhenDrivenHard) {
  const PlantParameters car = reference_car();
  const double l = car.front_axle + car.rear_axle;
  const PlantOutput out = steady(car, 2.2, 0.4).output();
  EXPECT_GT(std::abs(out.accel_y), 4.0);
  const double K = car.mass / l *
                   (car.rear_axle / car.cornering_stiffness_front -
                    car.front_axle / car.cornering_stiffness_rear);
  EXPECT_LT(out.yaw_rate, 0.95 * out.v_x * 0.4 / (l + K * out.v_x * out.v_x));
}

TEST(Plant, FrictionLimitsTheSideForce) {
  PlantParameters car = reference_car();
  car.patches = {{0.0, 0.0, 1000.0, 0.3}};
  const PlantOutput out = steady(car, 2.0, 0.4).output();
  EXPECT_LT(std::abs(out.accel_y), 0.3 * 9.81 * 1.02);
}

TEST(Plant, LoadMovesOutwardsAndToTheRear) {
  const PlantParameters car = reference_car();
  const auto turning = steady(car, 1.5, 0.2).loads();  // to the left
  EXPECT_GT(turning[front_right], turning[front_left]);
  EXPECT_GT(turning[rear_right], turning[rear_left]);
  double sum = 0.0;
  for (const double load : turning) sum += load;
  EXPECT_NEAR(sum, car.mass * 9.80665, 1e-9);

  Plant plant(car, 0.0, 0.0, 0.0);
  const auto standing = plant.loads();
  drive(plant, {.force = 2.0 * car.mass}, 0.3);
  EXPECT_GT(plant.loads()[rear_left], standing[rear_left]);
  EXPECT_LT(plant.loads()[front_left], standing[front_left]);
}

TEST(Plant, OnIceTheWheelsSpinUpToTheTopSpeedAndLockWhenBraked) {
  for (const CarKind kind : {CarKind::scale_car, CarKind::saloon}) {
    const PlantParameters car = ideal_car(kind, {{Parameter::friction, 0.05}});
    Plant plant(car, 0.0, 0.0, 0.0);
    drive(plant, {.force = 6.0 * car.mass}, 10.0);
    const double tread = plant.output().wheel_rate[rear_left] * car.wheel_radius[rear_left];
    EXPECT_LT(tread, 1.01 * car.top_speed);
    EXPECT_GT(tread, 0.7 * car.top_speed);
    EXPECT_LT(plant.output().v_x, 5.5);

    drive(plant, {.force = -6.0 * car.mass}, 1.0);
    ASSERT_GT(plant.output().v_x, 0.2);
    EXPECT_LT(std::abs(plant.output().wheel_rate[rear_left]) * car.wheel_radius[rear_left],
              0.1 * plant.output().v_x);
  }
}

TEST(Plant, StaysExactlyWhereItStands) {
  Plant plant(reference_car(), 1.0, 2.0, 0.3);
  drive(plant, {.steering = 0.3}, 2.0);
  EXPECT_EQ(plant.motion(), Movement::resting);
  EXPECT_EQ(plant.output().x, 1.0);
  EXPECT_EQ(plant.output().y, 2.0);
  EXPECT_EQ(plant.output().yaw, 0.3);
  EXPECT_EQ(plant.output().v_x, 0.0);
  EXPECT_EQ(plant.output().accel_x, 0.0);
  EXPECT_NEAR(plant.output().steering, 0.3, 1e-6);
}

TEST(Plant, CoastsToAnExactStopWithoutGainingEnergy) {
  const PlantParameters car = reference_car();
  Plant plant = steady(car, 1.0, 0.2, 1.0);
  // Skips the drive's lag; the tolerance below allows for energy from the tyres' springs.
  drive(plant, {.steering = 0.2}, 0.2);
  for (int k = 0; k < 60'000 && plant.motion() == Movement::rolling; ++k) {
    const double before = kinetic_energy(car, plant.output());
    plant.step({.steering = 0.2}, dt);
    EXPECT_LE(kinetic_energy(car, plant.output()), before + 1e-6);
  }
  EXPECT_EQ(plant.motion(), Movement::resting);
  EXPECT_EQ(plant.output().v_x, 0.0);
  EXPECT_EQ(plant.output().yaw_rate, 0.0);
}

TEST(Plant, StopsWithoutRollingBack) {
  const PlantParameters car = reference_car();
  Plant plant = steady(car, 1.5, 0.0, 0.5);
  double lowest = 0.0;
  for (int k = 0; k < 6000; ++k) {
    plant.step({.force = -4.0 * car.mass * plant.output().v_x}, dt);
    lowest = std::min(lowest, plant.output().v_x);
  }
  EXPECT_EQ(plant.motion(), Movement::resting);
  EXPECT_GT(lowest, -0.005);
}

TEST(Plant, ReversesAlongTheCircleOfItsRearAxle) {
  const PlantParameters car = reference_car();
  const PlantOutput out = steady(car, -0.5, 0.2).output();
  // At low speed ψ̇ = v tan δ / l, and the rear axle moves along the car.
  const double l = car.front_axle + car.rear_axle;
  EXPECT_NEAR(out.yaw_rate, out.v_x * std::tan(0.2) / l, 0.03 * std::abs(out.yaw_rate));
  EXPECT_NEAR(out.v_y, car.rear_axle * out.yaw_rate, 0.1 * std::abs(out.v_y));
  EXPECT_LT(out.yaw_rate, 0.0);
}

TEST(Plant, SteeringLagsAndKeepsItsRateLimit) {
  const PlantParameters car = reference_car();
  Plant plant(car, 0.0, 0.0, 0.0);
  double fastest = 0.0, before = 0.0;
  for (int k = 0; k < 400; ++k) {
    plant.step({.steering = 2.0}, dt);
    fastest = std::max(fastest, (plant.output().steering - before) / dt);
    before = plant.output().steering;
  }
  EXPECT_LE(fastest, car.steering_rate_limit * 1.0001);
  EXPECT_GT(fastest, 0.99 * car.steering_rate_limit);
  EXPECT_NEAR(before, car.steering_limit, 0.01);
  EXPECT_LE(before, car.steering_limit);
}

TEST(Plant, AFinerStepGivesTheSameCar) {
  const PlantParameters car = reference_car();
  const auto drive = [&](double step) {
    Plant plant(car, 0.0, 0.0, 0.0);
    for (int k = 0; k < std::lround(2.0 / step); ++k)
      plant.step({.steering = 0.2, .force = 1.5}, step);
    return plant.output();
  };
  const PlantOutput coarse = drive(0.0005), fine = drive(0.0001);
  EXPECT_NEAR(coarse.x, fine.x, 1e-4);
  EXPECT_NEAR(coarse.yaw, fine.yaw, 1e-4);
}

}  // namespace
}  // namespace odomd::sim::sim_plant_test
