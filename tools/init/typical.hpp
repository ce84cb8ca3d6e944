// Typical values of a class of cars, for numbers that nobody has measured.
#pragma once

namespace odomd::tools {

struct Typical {
  double inertia;                          ///< J_z / (m l_v l_h)
  double stiffness_front, stiffness_rear;  ///< C / weight on the axle [1/rad]
  double grip;                             ///< [m/s²]

  /// Front-wheel angle per lateral acceleration, beyond that of a turn without slip [s²/m].
  [[nodiscard]] double understeer() const {
    constexpr double gravity = 9.80665;
    return (1.0 / stiffness_front - 1.0 / stiffness_rear) / gravity;
  }
};

[[nodiscard]] inline Typical typical_for(double wheelbase) {
  constexpr double model_car = 1.0;  // m; shorter wheelbases are models
  return wheelbase < model_car ? Typical{0.5, 4.0, 6.0, 10.0} : Typical{1.0, 15.0, 22.0, 9.0};
}

}  // namespace odomd::tools
