// The command line of odom identify inertia: cords, weights and swings.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/cli/command.hpp"
#include "tools/identify/common/delivery.hpp"
#include "tools/identify/common/record.hpp"
#include "tools/identify/inertia/bifilar.hpp"
#include "tools/identify/inertia/propagation.hpp"
#include "tools/identify/inertia/swing_timing.hpp"

namespace odomd::tools {

struct InertiaOptions {
  RecordOptions record;
  std::vector<std::string> times;
  int swings = 0;
  std::vector<std::string> platform_times;
  int platform_swings = 0;
  std::string platform_mass, platform_mass_sigma, platform_inertia, platform_inertia_sigma;
  std::string mass, mass_sigma;
  std::string spacing, spacing_below, spacing_sigma = "0.5mm";
  std::string cord, cord_sigma = "2mm";
  std::string offset = "0", offset_sigma;
  std::string tilt = "2deg";
  std::string amplitude = "10deg", amplitude_end;
  std::string time_sigma = "0.15";
  std::string clock_sigma = "0.0001";
  std::string gyro_scale_sigma = "3%";
  std::string gravity;
  Delivery delivery;
};

/// Adds the options, the description and the examples.
void describe_inertia(Command command, InertiaOptions& options);

/// The following functions throw std::invalid_argument for impossible numbers.
[[nodiscard]] Bifilar pendulum_of(const InertiaOptions& options);

/// e², the squared offset of the centre of gravity from the middle of the cords [m²].
[[nodiscard]] Measured offset_square(const InertiaOptions& options, const Bifilar& pendulum);

[[nodiscard]] Measured mass_of_car(const InertiaOptions& options);
[[nodiscard]] StopWatch watch_of_car(const InertiaOptions& options);

/// The source of the inertia of the board under the car.
enum class Platform : std::uint8_t { none, swung, given };

/// Throws std::invalid_argument if options for it are incomplete.
[[nodiscard]] Platform platform_of(const InertiaOptions& options);
[[nodiscard]] Measured mass_of_platform(const InertiaOptions& options);
[[nodiscard]] StopWatch watch_of_platform(const InertiaOptions& options);   ///< if swung
[[nodiscard]] Measured inertia_of_platform(const InertiaOptions& options);  ///< if given

}  // namespace odomd::tools
