// Warnings about numbers of a configuration that are in another unit.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "daemon/core/config_sections.hpp"

namespace odomd::daemon::config_checks_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::vector<std::string> warnings_of(const std::function<void(Config&)>& change) {
  Config config;
  config.file = "car.toml";
  change(config);
  std::vector<std::string> warnings;
  check_sizes(config, warnings);
  return warnings;
}

TEST(ConfigChecks, AcceptCarsOfAnySize) {
  EXPECT_THAT(warnings_of([](Config&) {}), IsEmpty());  // the reference car
  const estimator::Vehicle cars[] = {
      {1.58, 0.0805, 0.093, 0.0048, 17.4, 21.9, 0.12},       // 1:10 with a light body
      {1500.0, 1.2, 1.5, 2500.0, 80'000, 100'000, 1.6},      // a saloon
      {230.0, 0.8, 0.75, 110.0, 12'000, 14'000, 1.2},        // formula student
      {18'000.0, 2.5, 3.5, 120'000, 300'000, 700'000, 2.1},  // a lorry
  };
  for (const estimator::Vehicle& car : cars)
    EXPECT_THAT(warnings_of([&](Config& config) { config.vehicle = car; }), IsEmpty()) << car.mass;
}

TEST(ConfigChecks, NameTheNumberThatIsInAnotherUnit) {
  const auto one = [](const char* text) { return ElementsAre(HasSubstr(text)); };
  EXPECT_THAT(warnings_of([](Config& c) { c.vehicle.yaw_inertia = 283.0; }),
              one("car.toml: [vehicle]: yaw_inertia 283 is 6.4e+03 times"));
  EXPECT_THAT(warnings_of([](Config& c) { c.vehicle.track_width = 160.0; }),
              one("track_width 160 m"));
  EXPECT_THAT(warnings_of([](Config& c) { c.vehicle.cornering_stiffness_rear = 0.6; }),
              one("cornering_stiffness_rear 0.6 is 0.02 times"));
  EXPECT_THAT(warnings_of([](Config& c) { c.vehicle.grip_front = 9500.0; }),
              one("grip_front 9500 is out of range for a tyre"));
  EXPECT_THAT(warnings_of([](Config& c) { c.vehicle.grip_rear = 0.1; }), one("grip_rear 0.1"));
  EXPECT_THAT(warnings_of([](Config& c) { c.vehicle.grip_front = c.vehicle.grip_rear = 9.0; }),
              IsEmpty());
  EXPECT_THAT(warnings_of([](Config& c) {
                c.camera.lever_arm = {50.0, 0.0, 0.0};
              }),
              one("car.toml: [camera] lever_arm: [50, 0] is 1.9e+02 wheelbases"));
  EXPECT_THAT(warnings_of([](Config& c) { c.imu_position = {0.0, -12.0}; }), one("[imu] position"));
  const auto grams = warnings_of([](Config& c) { c.vehicle.mass = 2985.0; });
  ASSERT_FALSE(grams.empty());
  EXPECT_THAT(grams.front(), HasSubstr("2985 kg on a wheelbase of 0.26 m does not fit a car"));
  const auto millimetres =
      warnings_of([](Config& c) { c.vehicle.front_axle = 175.0, c.vehicle.rear_axle = 85.0; });
  ASSERT_FALSE(millimetres.empty());
  EXPECT_THAT(millimetres.front(), HasSubstr("on a wheelbase of 260 m does not fit a car"));
}

}  // namespace
}  // namespace odomd::daemon::config_checks_test
