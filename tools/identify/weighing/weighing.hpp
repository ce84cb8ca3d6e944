// Mass and centre of gravity of a car from the loads under its wheels.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/identify/common/measured.hpp"

namespace odomd::tools {

/// The wheels on the scale.
enum class Load : std::uint8_t {
  total,
  front,
  rear,
  left,
  right,
  front_left,
  front_right,
  rear_left,
  rear_right,
  count
};
struct LoadInfo {
  std::string_view option;       ///< "front-left"
  std::array<double, 4> wheels;  ///< front left, front right, rear left, rear right
  std::string_view help;
};
[[nodiscard]] const LoadInfo& info_of(Load load);

struct Weighing {
  Load load = Load::total;
  double mass = 0.0;  ///< reading of the scale [kg]
};

struct Scale {
  double resolution = 0.0;  ///< the last digit [kg]; rounds one load the same way each time
  double sigma = 0.0;       ///< scatter of weighings of one load [kg]; 0: half of the last digit
  double accuracy = 0.0;    ///< standard uncertainty of the scale's gain, common to all weighings
  // Load shifted to other wheels by a slope [kg]; constant per load.
  double axle_shift = 0.0;
  double side_shift = 0.0;
};

/// The loads of the four wheels from generalised least squares: x = (front left, front right, rear
/// left, rear right). A set of weighings determines some sums of these and not others.
struct WheelLoads {
  Eigen::Vector4d load = Eigen::Vector4d::Zero();
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();  ///< without the gain
  Eigen::Matrix4d determined = Eigen::Matrix4d::Zero();  ///< projector onto determined sums
  double chi_square = 0.0;
  int excess = 0;  ///< weighings in addition to those that the unknowns need

  /// Whether the weighings determine a sum of wheel loads (`sum`: coefficients 0 or 1).
  [[nodiscard]] bool determine(const Eigen::Vector4d& sum) const;
};

/// The covariance grows if the weighings contradict each other by more than the scale explains.
/// Throws std::invalid_argument for no weighing, for an impossible load, or for a scale without any
/// uncertainty.
[[nodiscard]] WheelLoads wheel_loads(std::span<const Weighing> weighings, const Scale& scale);

/// Nothing if the weighings are consistent (99 %); otherwise a warning with their contradiction.
[[nodiscard]] std::optional<diagnostics::Diagnostic> contradiction(const WheelLoads& loads);

/// The mass, if the weighings determine it; its uncertainty includes that of the scale's gain.
[[nodiscard]] std::optional<Measured> mass_of(const WheelLoads& loads, const Scale& scale);

/// Throws std::invalid_argument, with the option, for an axle or a side that carries more than the
/// whole car.
void check_shares(const WheelLoads& loads);

struct Dimensions {
  Measured wheelbase;                   ///< [m]
  std::optional<Measured> track_width;  ///< [m]
  double level = 0.0;                   ///< standard uncertainty of the car's inclination [rad]
};

/// Adds the load shifts due to an unlevel floor, for a car of this mass [kg]: on a slope θ the line
/// of action of its weight moves by h tan θ.
[[nodiscard]] Scale with_slopes(Scale scale, double mass, const Dimensions& dimensions);

struct CentreOfGravity {
  std::optional<Measured> front_axle;  ///< l_v [m]
  std::optional<Measured> rear_axle;   ///< l_h [m]
  double correlation = 0.0;            ///< between the two axles' values
  std::optional<Measured> lateral;     ///< to the left of the centre line [m]
};

/// Paper, "Vehicle Center of Gravity": l_h = F_v l / (m g), l_v = F_h l / (m g).
[[nodiscard]] CentreOfGravity centre_of_gravity(const WheelLoads& loads,
                                                const Dimensions& dimensions);

}  // namespace odomd::tools
