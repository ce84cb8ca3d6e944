// Which models of the car there are.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace odomd::estimator {

enum class Model : std::uint8_t {
  kinematic,          ///< bicycle without slip, centre of gravity treated rightly (errata, 7)
  kinematic_printed,  ///< eqs 1-3 as printed, for comparison only
  paper,              ///< the paper's extended Kalman filter
  full,               ///< late samples at their own time, biases and scales, reverse, standstill
  inertial,           ///< the slip odometer: gyro, wheels and a steady turn's slip, no filter
};

/// As the configuration and the command line call them, in the order of the enumeration.
inline constexpr std::array<std::string_view, 5> model_names{"kinematic", "kinematic_printed",
                                                             "paper", "full", "inertial"};

}  // namespace odomd::estimator
