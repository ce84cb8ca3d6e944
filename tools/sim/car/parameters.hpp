// Every number that a run of the simulation may be given, in one table: its name, its unit, its
// default for each car, and how the truth of a run is drawn from it.
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

/// How the truth of a run comes from a parameter's value.
enum class Draw : std::uint8_t {
  exact,    ///< it is the value
  normal,   ///< drawn once a run with this standard deviation
  uniform,  ///< drawn once a run from minus to plus this
};

/// Whether an ideal car has it: errors are zero there.
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
  double minimum;    ///< of what may be asked for; what is drawn may be its negative
  double maximum;
  std::string_view meaning;
};

/// In the order of the enumeration; both are made from parameters.inc.
[[nodiscard]] std::span<const ParameterInfo, parameter_count> parameter_table();

/// One number for each parameter: what was asked for, or what was drawn.
class ParameterSet {
 public:
  [[nodiscard]] double operator[](Parameter p) const {
    return values_[static_cast<std::size_t>(p)];
  }
  double& operator[](Parameter p) { return values_[static_cast<std::size_t>(p)]; }

 private:
  std::array<double, parameter_count> values_{};
};

/// The 1:10 car and the saloon, whose bodies are rigid, and cars of published data, whose bodies
/// roll and pitch.
enum class CarKind : std::uint8_t { scale_car, saloon, bmw_320i, ford_escort, vw_vanagon };

enum class CarSize : std::uint8_t { scale, full };
[[nodiscard]] constexpr CarSize size_of(CarKind car) {
  return car == CarKind::scale_car ? CarSize::scale : CarSize::full;
}

/// Whether the car's body stands on springs.
[[nodiscard]] constexpr bool is_sprung(CarKind car) {
  return car != CarKind::scale_car && car != CarKind::saloon;
}

[[nodiscard]] ParameterSet default_parameters(CarKind car);

/// Default of all sprung cars.
[[nodiscard]] double sprung_default(Parameter parameter);

/// Sets every error to zero.
void make_ideal(ParameterSet& parameters);

/// The table's row of a name. Throws std::invalid_argument with the nearest name.
[[nodiscard]] const ParameterInfo& find_parameter(std::string_view name);

struct Assignment {
  Parameter parameter = Parameter::count;
  double value = 0.0;
};

/// Takes "name=value". Throws std::invalid_argument for what is not one.
[[nodiscard]] Assignment parse_assignment(std::string_view text);

/// A steering servo with dead time, lag and a rate limit, whose command is what the bus carries.
[[nodiscard]] std::vector<Assignment> slow_servo();

/// Throws std::invalid_argument for a value that may not be asked for.
void check(const ParameterInfo& info, double value);

/// The truth of a run. Each parameter has its own random stream.
[[nodiscard]] ParameterSet draw_truth(const ParameterSet& sizes, std::uint64_t seed);

}  // namespace odomd::sim
