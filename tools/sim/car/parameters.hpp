// All parameters of a run of the simulation, in one table: name, unit, default for each car, and
// how the truth of a run is drawn.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace odomd::sim {

enum class Parameter : std::uint8_t {
#define ODOMD_PARAMETER(name, ...) name,
#include "tools/sim/car/parameters.inc"
#undef ODOMD_PARAMETER
  count
};
inline constexpr std::size_t parameter_count = static_cast<std::size_t>(Parameter::count);

/// How the truth of a run is drawn from a parameter's value.
enum class Draw : std::uint8_t {
  exact,    ///< truth = value
  normal,   ///< once per run, with this standard deviation
  uniform,  ///< once per run, from -value to +value
};

/// An ideal car keeps the properties; its errors are 0.
enum class Nature : std::uint8_t { property, error };

struct ParameterInfo {
  Parameter parameter;
  std::string_view name;
  std::string_view unit;
  std::string_view group;
  Draw draw;
  Nature nature;
  double scale_car;  ///< default of the 1:10 car
  double saloon;     ///< default of the saloon of scenario road
  double published;  ///< default of the cars with published data
  double minimum;    ///< limits of values that users set; drawn values may be negative
  double maximum;
  std::string_view meaning;
};

/// In the order of the enumeration; both are generated from parameters.inc.
[[nodiscard]] std::span<const ParameterInfo, parameter_count> parameter_table();

/// One number for each parameter: the requested sizes, or the drawn truth.
class ParameterSet {
 public:
  [[nodiscard]] double operator[](Parameter p) const {
    return values_[static_cast<std::size_t>(p)];
  }
  double& operator[](Parameter p) { return values_[static_cast<std::size_t>(p)]; }

 private:
  std::array<double, parameter_count> values_{};
};

/// The 1:10 car and the saloon, whose bodies are rigid, and cars with published data, whose bodies
/// roll and pitch.
enum class CarKind : std::uint8_t { scale_car, saloon, bmw_320i, ford_escort, vw_vanagon };

enum class CarSize : std::uint8_t { scale, full };
[[nodiscard]] constexpr CarSize size_of(CarKind car) {
  return car == CarKind::scale_car ? CarSize::scale : CarSize::full;
}

/// Whether the car's body is on springs.
[[nodiscard]] constexpr bool is_sprung(CarKind car) {
  return car != CarKind::scale_car && car != CarKind::saloon;
}

[[nodiscard]] ParameterSet default_parameters(CarKind car);

/// Sets every error to zero.
void make_ideal(ParameterSet& parameters);

/// The table's row for a name. Throws std::invalid_argument with the nearest name.
[[nodiscard]] const ParameterInfo& find_parameter(std::string_view name);

struct Assignment {
  Parameter parameter = Parameter::count;
  double value = 0.0;
};

/// Parses "name=value". Throws std::invalid_argument for other text.
[[nodiscard]] Assignment parse_assignment(std::string_view text);

/// Settings for a steering servo with dead time, lag and a rate limit; the bus carries its command.
[[nodiscard]] std::vector<Assignment> slow_servo();

/// Throws std::invalid_argument if the value is outside the parameter's limits.
void check(const ParameterInfo& info, double value);

/// The truth of a run. Each parameter has its own random stream.
[[nodiscard]] ParameterSet draw_truth(const ParameterSet& sizes, std::uint64_t seed);

}  // namespace odomd::sim
