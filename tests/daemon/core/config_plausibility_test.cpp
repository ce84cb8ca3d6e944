// Warnings about values of a configuration that seem to be in another unit.
#include <functional>

#include "daemon/core/config_sections.hpp"
#include "tests/diagnostics.hpp"
#include "tests/gtest.hpp"

namespace odomd::daemon::config_plausibility_test {
namespace {

using diagnostics::Named;

diagnostics::Diagnostics warnings_of(const std::function<void(Config&)>& change) {
  Config config;
  config.file = "car.toml";
  change(config);
  diagnostics::Diagnostics warnings;
  check_sizes(config, warnings);
  return warnings;
}

TEST(ConfigChecks, AcceptCarsOfAnySize) {
  EXPECT_THAT(warnings_of([](Config&) {}), IsEmpty());  // the reference car
  const estimator::Vehicle cars[] = {
      {1.58, 0.0805, 0.093, 0.0048, 17.4, 21.9, 0.12},                 // 1:10 with a light body
      {1500.0, 1.2, 1.5, 2500.0, 80'000, 100'000, 1.6},                // a saloon
      {230.0, 0.8, 0.75, 110.0, 12'000, 14'000, 1.2},                  // formula student
      {18'000.0, 2.5, 3.5, 120'000, 300'000, 700'000, 2.1, 9.0, 9.0},  // a lorry
  };
  for (const estimator::Vehicle& car : cars)
    EXPECT_THAT(warnings_of([&](Config& config) { config.vehicle = car; }), IsEmpty()) << car.mass;
}

TEST(ConfigChecks, NameTheNumberThatIsInAnotherUnit) {
  struct Case {
    const char *warning, *text;
    void (*change)(Config&);
  };
  const Case cases[]{
      {"inertia_unlike_a_car", "car.toml: [vehicle]: yaw_inertia 283 is 6.4e+03 times",
       [](Config& c) { c.vehicle.yaw_inertia = 283.0; }},
      {"track_unlike_a_car", "track_width 160 m", [](Config& c) { c.vehicle.track_width = 160.0; }},
      {"stiffness_unlike_a_tyre", "cornering_stiffness_rear 0.6 is 0.02 times",
       [](Config& c) { c.vehicle.cornering_stiffness_rear = 0.6; }},
      {"grip_unlike_a_tyre", "grip_front 9500", [](Config& c) { c.vehicle.grip_front = 9500.0; }},
      {"grip_unlike_a_tyre", "grip_rear 0.1", [](Config& c) { c.vehicle.grip_rear = 0.1; }},
      {"sensor_outside_car", "car.toml: [camera] lever_arm: [50, 0] is 1.9e+02 wheelbases",
       [](Config& c) { c.camera.lever_arm[0] = 50.0; }},
      {"sensor_outside_car", "car.toml: [reference] lever_arm: [0, -50]",
       [](Config& c) { c.reference_lever_arm.emplace()[1] = -50.0; }},
      {"sensor_outside_car", "[imu] position", [](Config& c) { c.imu_position[1] = -12.0; }}};
  for (const auto& [warning, text, change] : cases)
    EXPECT_THAT(warnings_of(change), ElementsAre(Named(warning, text)));
  const auto grams = warnings_of([](Config& c) { c.vehicle.mass = 2985.0; });
  EXPECT_THAT(grams, Contains(Named("mass_unlike_a_car", "2985 kg on a wheelbase of 0.26 m")));
  const auto millimetres =
      warnings_of([](Config& c) { c.vehicle.front_axle = 175.0, c.vehicle.rear_axle = 85.0; });
  EXPECT_THAT(millimetres, Contains(Named("mass_unlike_a_car", "on a wheelbase of 260 m")));
}

}  // namespace
}  // namespace odomd::daemon::config_plausibility_test
