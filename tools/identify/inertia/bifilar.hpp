// The bifilar pendulum: a body on two cords that oscillates about the vertical axis.
//
// At an angle θ it is raised by z(θ) = h(0) - h(θ), h² = L² - a² - b² + 2 p cos θ, with the cords'
// attachment points 2a apart above and 2b below, and p = a b for a body in the middle. Equation of
// motion:
//
//   (J + m z'²) θ" + m z' z" θ'² + m g z' + c θ' + d |θ'| θ' = 0,   z' = p sin θ / h.
//
// For small swings T = 2π sqrt(J h(0) / (m g p)). For a = b = D/2 this is the paper's formula (eq.
// 23), which is printed with π in place of π²: J = m g D² T² / (16 π² L).
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/identify/common/measured.hpp"
#include "tools/identify/common/signal_log.hpp"

namespace odomd::tools {

struct Bifilar {
  double spacing_above = 0.0;  ///< between the cords' attachment points [m]
  double spacing_below = 0.0;  ///< distance of the attachment points at the body [m]
  double cord = 0.0;           ///< length of a cord, L [m]
  double offset = 0.0;         ///< of the centre of gravity from the midpoint of the cords [m]

  /// p: if off the midpoint by e, the cords are at b ± e: p = a b (1 - (e/b)²).
  [[nodiscard]] double product() const {
    const double off = 2.0 * offset / spacing_below;
    return 0.25 * spacing_above * spacing_below * (1.0 - off * off);
  }
  /// h(0): height of the upper attachment points above the lower ones.
  [[nodiscard]] double height() const {
    const double apart = 0.5 * (spacing_above - spacing_below);
    return std::sqrt(cord * cord - apart * apart);
  }
  /// h(θ); NaN if the cords are too short.
  [[nodiscard]] double height(double angle) const {
    const double sine = std::sin(0.5 * angle);
    const double straight = height();
    return std::sqrt(straight * straight - 4.0 * product() * sine * sine);
  }
};

/// Throws std::invalid_argument, naming the option, for impossible dimensions.
void check(const Bifilar& pendulum);

/// For an error message: asks whether --spacing and --cord are swapped if the cords are shorter
/// than the distance between them; otherwise empty.
[[nodiscard]] std::string exchange_hint(const Bifilar& pendulum);

/// Throws std::invalid_argument for a period that is impossible for a car on these cords: its
/// radius of gyration would be over ten times the distance between the cords, or under a tenth; and
/// for a mass [kg] that does not fit this radius.
void check_size(const Bifilar& pendulum, double period, double mass);

/// J/m = k² [m²] of a body with this period of small swings; k is its radius of gyration.
[[nodiscard]] double inertia_per_mass(const Bifilar& pendulum, double period,
                                      double gravity = 9.81);

/// T(amplitude) / T(0) of undamped swings between ±amplitude [rad] of a body with this k² [m²],
/// T(0) being the period of small swings; by quadrature of the energy equation. Throws
/// std::invalid_argument for an amplitude that the cords do not allow.
[[nodiscard]] double lengthening(const Bifilar& pendulum, double radius_squared, double amplitude);

// The period from a stop-watch.

struct StopWatch {
  std::vector<double> times;  ///< durations of `swings` swings each [s]
  int swings = 0;
  double sigma = 0.0;            ///< of a timing [s]
  double amplitude_begin = 0.0;  ///< of the first timed swing [rad]
  double amplitude_end = 0.0;    ///< of the last timed swing [rad]
};

struct TimedSwing {
  Measured period;           ///< of small, undamped swings [s]
  double lengthening = 0.0;  ///< relative excess of the timed period over `period`
  diagnostics::Diagnostics warnings;
};

/// The mean of the timings, corrected for amplitude and damping; a quarter of the correction counts
/// as uncertainty. Throws std::invalid_argument for impossible values.
[[nodiscard]] TimedSwing small_period_of(const StopWatch& watch, const Bifilar& pendulum);

// The period from a gyro's record: the times at which the car turns back.

struct SwingFit {
  Measured period;               ///< of small, undamped swings [s]
  double amplitude_begin = 0.0;  ///< of the first and the last swing [rad]
  double amplitude_end = 0.0;
  double gyro_bias = 0.0;  ///< [rad/s]
  double swings = 0.0;
  diagnostics::Diagnostics warnings;
};

/// Uses the record from its largest rate until the swing has decayed to a seventh. `name` is the
/// record's name in messages. Throws std::invalid_argument if the record shows no swing, or is too
/// short.
[[nodiscard]] SwingFit fit_swing(const Series& yaw_rate, const Bifilar& pendulum,
                                 const std::string& name);

}  // namespace odomd::tools
