// Settings of a filter in SI units, including the vehicle.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "estimator/common/measurement.hpp"
#include "estimator/common/tuning.hpp"
#include "estimator/common/vehicle.hpp"

namespace odomd::estimator {

enum class Model : std::uint8_t {
  kinematic,          ///< bicycle without slip, with the correct centre of gravity (errata, 7)
  kinematic_printed,  ///< eqs 1-3 as printed, for comparison only
  paper,              ///< the paper's extended Kalman filter
  full,               ///< late samples at their own time, biases and scales, reverse, standstill
  inertial,           ///< the slip odometer: gyro, wheels and a steady turn's slip, no filter
};

/// The models' names in the configuration and on the command line, in the order of the enumeration.
inline constexpr std::array<std::string_view, 5> model_names{"kinematic", "kinematic_printed",
                                                             "paper", "full", "inertial"};

/// Noise of the paper's filter per 5 ms step, as printed (errata, 6): diagonals.
struct PaperNoise {
  std::array<double, 3> Q{0.05, 0.01, 0.01};  ///< of (v_x, v_y, ψ̇)
  std::array<double, 2> R{0.125, 0.10};       ///< of (ψ̇, v_x)
};

/// Standard deviation of a pose that is set [m, rad].
inline constexpr double initial_sigma = 0.05;

/// Time without a fused camera pose after which the mode is dead reckoning [s].
inline constexpr double camera_timeout_s = 0.5;

struct FilterSettings {
  Vehicle vehicle;
  double period_s = 0.005;
  PaperNoise paper;
  Tuning tuning;
  std::array<double, 2> imu_position{};  ///< ahead and left of the centre of gravity [m]
  /// Roll and pitch of the body: measured a = (1 + gradient) a. Learnt, from 0, if not set.
  std::optional<double> roll_gradient;
  std::optional<double> pitch_gradient;
  double window_s = 0.25;  ///< a sample may be this late

  /// Standard deviations of samples that state none.
  std::array<double, source_count> sigma = default_sigma;

  /// A wheel may turn at up to this speed while it reads 0 [m/s]. 0: learnt from readings.
  std::array<double, source_count> dead_band{};

  bool initialise_from_camera = false;  ///< wait for a camera pose if no initial pose is set
  double camera_max_latency_s = 0.2;    ///< older poses are too_old
  double camera_gate = 16.27;           ///< χ² with 3 degrees of freedom, 99.9 %
};

}  // namespace odomd::estimator
