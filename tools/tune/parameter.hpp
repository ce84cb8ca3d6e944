// A number of the configuration that odom tune varies, and its range.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace odomd::tools {

/// The scale of a range: a range above zero is logarithmic, any other linear.
enum class Scale : std::uint8_t { linear, logarithmic };

struct Parameter {
  std::string key;  ///< "filter.front_angle_error", "can.signals.yaw_rate.sigma", "imu.position[0]"
  double from = 0.0;
  double to = 0.0;
  Scale scale = Scale::linear;
  std::vector<double> values;  ///< to be swept; empty: the range is searched
};

/// "KEY=FROM:TO" (searched), "KEY=FROM:TO:N" (N values, both ends among them) or "KEY=A,B,C".
/// Throws std::invalid_argument that says what is wrong.
[[nodiscard]] Parameter parse_parameter(const std::string& text);

/// The value at a place of the range, 0 to 1, with four significant digits; and the place of a
/// value, held to the range.
[[nodiscard]] double value_at(const Parameter& parameter, double place);
[[nodiscard]] double place_of(const Parameter& parameter, double value);

}  // namespace odomd::tools
