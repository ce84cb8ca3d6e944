// The parameters of `odom identify fit`: each a number with its prior uncertainty and its key.
//
// A parameter p is relative to the configuration: positive values are configured · e^p, all others
// configured + p. So p = 0 is the configuration.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "daemon/core/config.hpp"

namespace odomd::tools::fitting {

enum Parameter : std::size_t {
#define ODOMD_FIT(name, ...) name,
#include "tools/identify/fit/parameters.inc"
#undef ODOMD_FIT
  parameters
};

template <class T>
using Numbers = std::array<T, parameters>;

/// The scale of a wheel's speed.
[[nodiscard]] constexpr Parameter wheel_scale(estimator::Source wheel) {
  const auto* const place = std::ranges::find(estimator::wheel_sources, wheel);
  const auto number = static_cast<std::size_t>(place - estimator::wheel_sources.begin());
  return static_cast<Parameter>(wheel_scale_front_left + number);
}
static_assert(wheel_scale(estimator::wheel_sources.back()) + 1 == wheel_slip);

[[nodiscard]] constexpr Parameter wheel_latency(estimator::Source wheel) {
  return is_front(wheel) ? wheel_latency_front : wheel_latency_rear;
}

enum class ParameterKind : std::uint8_t {
  factor,  ///< configured · e^p
  shift    ///< configured + p
};

struct ParameterInfo {
  Parameter parameter{};
  std::string_view name;  ///< as in --fix, --free and --prior
  ParameterKind kind{};
  std::string_view unit;
  std::string_view meaning;
  // Standard deviations of p. The unit for positions is the wheelbase.
  double prior = 0.0;        ///< before the fit
  double model_error = 0.0;  ///< of a fit over many speeds, added to the sigma from the residuals
};

/// In the order of the enumeration; both are generated from parameters.inc.
[[nodiscard]] const std::array<ParameterInfo, parameters>& parameter_table();

/// Throws std::invalid_argument with the most similar name.
[[nodiscard]] const ParameterInfo& parameter_named(std::string_view name);

/// The minimum duration of a drive [s].
inline constexpr double least_duration = 10.0;

/// NAME=SIGMA of --prior; without a parameter, sigma is that of the mass.
struct Prior {
  std::optional<Parameter> parameter;
  double sigma = 0.0;
};
/// Throws std::invalid_argument.
[[nodiscard]] Prior parse_prior(const std::string& text);

/// Whether accelerations come in the gyro's message: their latency is then the gyro's, and
/// `accel_latency` is not used.
[[nodiscard]] bool one_imu(const daemon::Config& config);

/// The value for p = 0 in SI units: the configuration's, or the usual value for such a car.
[[nodiscard]] Numbers<double> nominal_values(const daemon::Config& config);

/// ParameterInfo::prior or ::model_error of each p, in its unit.
[[nodiscard]] Numbers<double> sigmas_of(double ParameterInfo::*which, double wheelbase);

/// The parameter's value for a given p.
[[nodiscard]] double value_of(const ParameterInfo& info, double nominal, double p);

/// The factor p between an axle's stiffness and the slip of driven wheels: κ = p · m / C_h · a_x.
inline constexpr double usual_slip = 0.5;

}  // namespace odomd::tools::fitting
