// Cornering stiffnesses from steady circles: the paper's measurement with the exact formulas, over
// all circles at once.
//
// On a steady circle the side forces follow from the balance of force and yaw moment,
//
//   F_h = l_v m a_y / l,     F_v = (l_h m a_y / l + R_v sin δ) / cos δ,     a_y = v_x ψ̇,
//
// (eqs 25 and 27 with a_x ≈ 0, without the small angles of eq. 26;
// R_v = c_r m g l_h / l is the rolling resistance of the front axle) and the slip angles from the
// film's drift angle β and the log's steering angle,
//
//   v_x = v cos β,   v_y = v sin β,   α_v = δ - atan2(v_y + l_v ψ̇, v_x),
//   α_h = -atan2(v_y - l_h ψ̇, v_x).
//
// C = F / α (eqs 24 and 27) for small slip. The force is known well and the angle is not, so the
// fit is of angles over forces, by a curve that saturates at the grip D of the axle, F = D tanh(C α
// / D), that is
//
//   α = F / C · atanh(u) / u,   u = F / D,   D = μ F_z.
//
// Its slope at zero slip, C, is sought for both axles together with what would bias it: the angle
// between the markers' line and the car, the place of the centre of gravity between the markers,
// the steering's offset and scale, and the uncertainties of mass, axles, scale and rolling
// resistance, each held by what is known of it. Slow circles determine the first four; circles to
// both sides separate offsets from slip.
#pragma once

#include <span>
#include <vector>

#include "tools/identify/common/measured.hpp"
#include "tools/identify/stiffness/circle_runs.hpp"

namespace odomd::tools {

/// What is known of the car and the film beforehand.
struct CircleCar {
  Measured mass;                 ///< [kg]
  Measured front_axle;           ///< l_v [m]
  Measured rear_axle;            ///< l_h [m]
  Measured rolling_resistance;   ///< coefficient
  double sigma_scale = 0.0;      ///< of the film's metres, as a part
  double sigma_marker = 0.0;     ///< of each marker's place on the car [m]
  double marker_distance = 0.0;  ///< [m]

  [[nodiscard]] double wheelbase() const { return front_axle.value + rear_axle.value; }
};

/// A circle as one axle saw it.
struct AxlePoint {
  double slip = 0.0;    ///< α [rad], with the offsets that were found taken off
  double force = 0.0;   ///< F [N]
  double sigma = 0.0;   ///< of the slip angle, from the run's scatter [rad]
  double weight = 1.0;  ///< of the robust fit
};

struct AxleStiffness {
  Measured stiffness;  ///< C, slope at zero slip [N/rad]
  double grip = 0.0;   ///< D, where the curve saturates [N]
  std::vector<AxlePoint> points;

  /// Known to no better than a quarter: too little to be written anywhere.
  [[nodiscard]] bool is_undetermined() const { return 4.0 * stiffness.sigma > stiffness.value; }
  /// Slip at which the curve has fallen a tenth below the line [rad].
  [[nodiscard]] double linear_range() const;
  /// F(α)
  [[nodiscard]] double force(double slip) const;
};

struct CorneringStiffness {
  AxleStiffness front, rear;
  Measured steering_offset;  ///< what the log says when the wheels point straight ahead [rad]
  Measured steering_scale;   ///< log's angle over the wheels'
  Measured marker_angle;     ///< the markers' line against the car [rad]
  /// What the circles say of these by themselves, where nothing was known of them beforehand: the
  /// place of the centre of gravity ahead of where the markers put it [m], the steering's scale.
  Measured centre_ahead, free_steering_scale;
  double scatter = 1.0;        ///< the circles disagree so many times as much as each by itself
  std::size_t used = 0;        ///< circles whose weight is more than a half
  std::vector<bool> in_range;  ///< which circles were fitted, of those given
};

/// Throws std::invalid_argument if there is no circle, or all are too slow to determine a
/// stiffness.
[[nodiscard]] CorneringStiffness fit_stiffness(std::span<const CircleRun> runs,
                                               const CircleCar& car);

}  // namespace odomd::tools
