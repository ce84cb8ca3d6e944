// Simulated cars without errors, and steady motion, for the tests of the car.
#pragma once

#include "tests/gtest.hpp"
#include "tests/tools/sim/sensors/moments.hpp"
#include "tools/sim/car/plant.hpp"

namespace odomd::sim {

inline constexpr double plant_dt = 0.0005;  // step of the integration [s]

/// A car without errors; `changes` replace its parameters.
inline PlantParameters ideal_car(CarKind kind, const std::vector<Assignment>& changes = {}) {
  return true_vehicle(kind, ideal_parameters(changes, kind));
}

inline void drive(Plant& plant, const PlantInput& input, double seconds) {
  for (long k = 0; k < std::lround(seconds / plant_dt); ++k) plant.step(input, plant_dt);
}

/// The car after some seconds at a speed; `gain`: throttle / (mass · speed error) [1/s].
inline Plant steady(const PlantParameters& car, double speed, double steering, double seconds,
                    double gain, const RoadTilt& road = {}) {
  Plant plant(car, 0.0, 0.0, 0.0);
  plant.set_speed(speed);
  for (long k = 0; k < std::lround(seconds / plant_dt); ++k)
    plant.step({.steering = steering,
                .force = gain * car.mass * (speed - plant.output().v_x),
                .road = road},
               plant_dt);
  return plant;
}

/// Kinetic energy of the body and the wheels [J].
inline double kinetic_energy(const PlantParameters& p, const PlantOutput& o) {
  double energy = 0.5 * p.mass * (o.v_x * o.v_x + o.v_y * o.v_y) +
                  0.5 * p.yaw_inertia * o.yaw_rate * o.yaw_rate;
  for (std::size_t wheel = 0; wheel < wheel_count; ++wheel)
    energy += 0.5 * p.spin_inertia(wheel) * o.wheel_rate[wheel] * o.wheel_rate[wheel];
  return energy;
}

}  // namespace odomd::sim
