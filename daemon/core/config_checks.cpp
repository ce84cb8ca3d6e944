// Plausibility checks: warns of numbers that no car has, usually because they are in another unit.
// The checks use ratios, which hold for a model car and for a lorry, with wide ranges, so that
// unusual cars are accepted.
#include <cmath>

#include <fmt/format.h>

#include "daemon/core/config_sections.hpp"
#include "estimator/common/tuning.hpp"

namespace odomd::daemon {
namespace {

struct Range {
  double least;
  double most;
  [[nodiscard]] bool holds(double value) const { return value >= least && value <= most; }
};

constexpr Range mass_of_cube{5.0, 3000.0};    // m/l³ [kg/m³]; a lorry 80, a 1:10 car 170 to 300
constexpr Range inertia_of_axles{0.15, 6.0};  // J_z/(m l_v l_h); 0.4 to 1.2
constexpr Range track_of_base{0.2, 2.0};      // 0.5 to 0.8
constexpr Range stiffness_of_weight{0.05, 80.0};  // C/(m g) [1/rad]; 0.6 to 10
constexpr Range grip{0.3, 50.0};                  // [m/s²]; ice 1, a racing car's with wings 40
constexpr double farthest_sensor = 3.0;           // wheelbases from the centre of gravity

void check_vehicle(const Config& config, std::vector<std::string>& warnings) {
  const estimator::Vehicle& car = config.vehicle;
  const double base = car.wheelbase();
  const auto warn = [&](const std::string& what) {
    warnings.push_back(fmt::format("{}: [vehicle]: {}", config.file.string(), what));
  };
  if (!mass_of_cube.holds(car.mass / (base * base * base)))
    warn(
        fmt::format("{} kg on a wheelbase of {} m does not fit a car: give mass in kilograms, "
                    "front_axle and rear_axle in metres",
                    car.mass, base));
  const double inertia = car.yaw_inertia / (car.mass * car.front_axle * car.rear_axle);
  if (!inertia_of_axles.holds(inertia))
    warn(
        fmt::format("yaw_inertia {} is {:.2g} times mass·front_axle·rear_axle; for cars this "
                    "factor is about 1: give it in kg·m²",
                    car.yaw_inertia, inertia));
  if (!track_of_base.holds(car.track_width / base))
    warn(
        fmt::format("track_width {} m on a wheelbase of {} m does not fit a car: give it in metres",
                    car.track_width, base));
  for (const auto& [key, value] :
       {std::pair{"cornering_stiffness_front", car.cornering_stiffness_front},
        std::pair{"cornering_stiffness_rear", car.cornering_stiffness_rear}})
    if (const double share = value / (car.mass * estimator::gravity);
        !stiffness_of_weight.holds(share))
      warn(
          fmt::format("{} {} is {:.2g} times the car's weight per radian; for tyres this factor is "
                      "0.5 to 10: give it in N/rad for the whole axle",
                      key, value, share));
  for (const auto& [key, value] :
       {std::pair{"grip_front", car.grip_front}, std::pair{"grip_rear", car.grip_rear}})
    if (value > 0.0 && !grip.holds(value))
      warn(
          fmt::format("{} {} is out of range for a tyre; on a road it is 5 to 15: give it in m/s², "
                      "as lateral force divided by the mass on the axle",
                      key, value));
}

}  // namespace

void check_sizes(const Config& config, std::vector<std::string>& warnings) {
  check_vehicle(config, warnings);
  const double base = config.vehicle.wheelbase();
  const auto warn_if_far = [&](std::string_view key, double x, double y) {
    if (std::hypot(x, y) > farthest_sensor * base)
      warnings.push_back(fmt::format(
          "{}: {}: [{}, {}] is {:.2g} wheelbases from the centre of gravity: give it in metres",
          config.file.string(), key, x, y, std::hypot(x, y) / base));
  };
  warn_if_far("[camera] lever_arm", config.camera.lever_arm[0], config.camera.lever_arm[1]);
  warn_if_far("[imu] position", config.imu_position[0], config.imu_position[1]);
}

}  // namespace odomd::daemon
