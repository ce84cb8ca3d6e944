// Plausibility checks: warns of numbers that no car has, usually because they are in another unit.
// The checks use ratios, which hold for a model car and for a lorry, with wide ranges, so that
// unusual cars are accepted.
#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "daemon/core/config_sections.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "estimator/common/tuning.hpp"

namespace odomd::daemon {
namespace {

using diagnostics::found;
using diagnostics::kind;

void check_vehicle(const Config& config, diagnostics::Diagnostics& warnings) {
  const estimator::Vehicle& car = config.vehicle;
  const double base = car.wheelbase();
  const auto check = [&](const diagnostics::Kind& kind, double value, const std::string& seen) {
    if (!kind.limits.hold(value))
      warnings.push_back(found(kind, config.file.string() + ": [vehicle]", seen));
  };
  check(kind("mass_unlike_a_car"), car.mass / (base * base * base),
        fmt::format("{} kg on a wheelbase of {} m does not fit a car", car.mass, base));
  const double inertia = car.yaw_inertia / (car.mass * car.front_axle * car.rear_axle);
  check(kind("inertia_unlike_a_car"), inertia,
        fmt::format("yaw_inertia {} is {:.2g} times mass·front_axle·rear_axle; for cars this "
                    "factor is about 1",
                    car.yaw_inertia, inertia));
  check(kind("track_unlike_a_car"), car.track_width / base,
        fmt::format("track_width {} m on a wheelbase of {} m does not fit a car", car.track_width,
                    base));
  for (const auto& [key, value] :
       {std::pair{"cornering_stiffness_front", car.cornering_stiffness_front},
        std::pair{"cornering_stiffness_rear", car.cornering_stiffness_rear}}) {
    const double share = value / (car.mass * estimator::gravity);
    check(kind("stiffness_unlike_a_tyre"), share,
          fmt::format("{} {} is {:.2g} times the car's weight per radian; for tyres this factor is "
                      "0.5 to 10",
                      key, value, share));
  }
  for (const auto& [key, value] :
       {std::pair{"grip_front", car.grip_front}, std::pair{"grip_rear", car.grip_rear}})
    if (value > 0.0)
      check(kind("grip_unlike_a_tyre"), value,
            fmt::format("{} {} is out of range for a tyre; on a road it is 5 to 15", key, value));
}

}  // namespace

void check_sizes(const Config& config, diagnostics::Diagnostics& warnings) {
  check_vehicle(config, warnings);
  const double base = config.vehicle.wheelbase();
  const auto check = [&](const std::string& key, double x, double y) {
    const double wheelbases = std::hypot(x, y) / base;
    if (!kind("sensor_outside_car").limits.hold(wheelbases))
      warnings.push_back(
          found(kind("sensor_outside_car"), config.file.string() + ": " + key,
                fmt::format("[{}, {}] is {:.2g} wheelbases from the centre of gravity", x, y,
                            wheelbases)));
  };
  check("[camera] lever_arm", config.camera.lever_arm[0], config.camera.lever_arm[1]);
  if (const auto& arm = config.reference_lever_arm)
    check("[reference] lever_arm", (*arm)[0], (*arm)[1]);
  check("[imu] position", config.imu_position[0], config.imu_position[1]);
}

}  // namespace odomd::daemon
