// Cornering stiffnesses from steady circles: the paper's measurement with the exact formulas, for
// all circles at once.
//
// On a steady circle the side forces follow from the balance of force and yaw moment,
//
//   F_h = l_v m a_y / l,     F_v = (l_h m a_y / l + R_v sin δ) / cos δ,     a_y = v_x ψ̇,
//
// (eqs 25 and 27 with a_x ≈ 0, without the small-angle approximations of eq. 26; R_v = c_r m g l_h
// / l is the rolling resistance of the front axle). The slip angles follow from the film's drift
// angle β and the log's steering angle,
//
//   v_x = v cos β,   v_y = v sin β,   α_v = δ - atan2(v_y + l_v ψ̇, v_x),
//   α_h = -atan2(v_y - l_h ψ̇, v_x).
//
// C = F / α (eqs 24 and 27) for small slip. The force is known well and the angle is not, so angles
// are fitted as a function of the force, with a curve that saturates at the axle's grip D, F = D
// tanh(C α / D), that is
//
//   α = F / C · atanh(u) / u,   u = F / D,   D = μ F_z.
//
// Its slope at zero slip, C, is fitted for both axles together with the unknowns that would bias
// it, each with its prior: the angle between the markers' line and the car, the position of the
// centre of gravity between the markers, the steering's offset and scale, and the errors of mass,
// axles, scale and rolling resistance. Slow circles determine the first four; circles in both
// directions separate offsets from slip.
#pragma once

#include <span>
#include <vector>

#include "tools/chart/picture.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/identify/stiffness/film.hpp"

namespace odomd::tools {

/// Prior knowledge of the car and the film.
struct CircleCar {
  Measured mass;                 ///< [kg]
  Measured front_axle;           ///< l_v [m]
  Measured rear_axle;            ///< l_h [m]
  Measured rolling_resistance;   ///< coefficient
  double sigma_scale = 0.0;      ///< relative, of the film's metres
  double sigma_marker = 0.0;     ///< of each marker's position on the car [m]
  double marker_distance = 0.0;  ///< [m]

  [[nodiscard]] double wheelbase() const { return front_axle.value + rear_axle.value; }
};

/// One axle on one circle.
struct AxlePoint {
  double slip = 0.0;    ///< α less the fitted offsets [rad]
  double force = 0.0;   ///< F [N]
  double sigma = 0.0;   ///< of the slip angle, from the circle's scatter [rad]
  double weight = 1.0;  ///< in the robust fit
};

struct AxleStiffness {
  Measured stiffness;  ///< C, slope at zero slip [N/rad]
  double grip = 0.0;   ///< D, the limit of the curve [N]
  std::vector<AxlePoint> points;

  /// Whether the uncertainty exceeds a quarter: then the stiffness must not be written.
  [[nodiscard]] bool is_undetermined() const { return 4.0 * stiffness.sigma > stiffness.value; }
  /// Slip angle at which the curve is a tenth below the line [rad].
  [[nodiscard]] double linear_range() const;
  /// F(α)
  [[nodiscard]] double force(double slip) const;
};

struct CorneringStiffness {
  AxleStiffness front, rear;
  Measured steering_offset;  ///< the log's angle when the wheels point straight ahead [rad]
  Measured steering_scale;   ///< angle in the log / angle of the wheels
  Measured marker_angle;     ///< angle of the markers' line against the car [rad]
  /// From the circles alone, without prior knowledge of these two: how far the centre of gravity is
  /// ahead of where the markers place it [m], and the steering's scale.
  Measured centre_ahead, free_steering_scale;
  double scatter = 1.0;        ///< ratio of the circles' scatter to their own sigmas
  std::size_t used = 0;        ///< circles with a weight above one half
  std::vector<bool> in_range;  ///< for each given circle, whether it was fitted

  /// Whether the fitted curves explain a circle.
  [[nodiscard]] bool is_used(std::size_t circle) const {
    return front.points[circle].weight > 0.5 && rear.points[circle].weight > 0.5;
  }
};

/// Throws std::invalid_argument if there is no circle, or if all are too slow to determine a
/// stiffness.
[[nodiscard]] CorneringStiffness fit_stiffness(std::span<const CircleRun> runs,
                                               const CircleCar& car);

// The circles of all films: mistakes that no fit can correct, and the results of the fit as numbers
// for the configuration, a table and a picture.

struct FilmedCircles {
  std::vector<CircleRun> circles;
  std::vector<FilmAlignment> alignments;  ///< offsets from the log's first frame
  diagnostics::Diagnostics warnings;
};

/// Throws std::invalid_argument if most circles are driven backwards or sideways, or if the
/// steering has the wrong sign or a wrong size: markers or their X and Y exchanged, sign or scale
/// of the steering.
void check_circles(std::span<const CircleRun> circles, double wheelbase);

/// Warnings: parameters that a fit cannot separate without other circles, and an accelerometer that
/// contradicts the film's scale.
[[nodiscard]] diagnostics::Diagnostics circle_warnings(std::span<const CircleRun> circles);

/// Throws std::invalid_argument if the circles determine neither axle's stiffness to a quarter.
void require_slip(const CorneringStiffness& found);

/// Contradictions between the circles and a sensor, the configuration or the markers' positions
/// that are so large that the stiffness cannot be trusted.
[[nodiscard]] diagnostics::Diagnostics contradictions(const FilmedCircles& films,
                                                      const CorneringStiffness& found,
                                                      const CircleCar& car);

/// If `against` has entries, the stiffnesses are not determined.
[[nodiscard]] Findings stiffness_findings(const FilmedCircles& films,
                                          const CorneringStiffness& found,
                                          const diagnostics::Diagnostics& against);

/// Front axle, rear axle.
[[nodiscard]] std::vector<chart::Drawing> draw_stiffness(const CorneringStiffness& found);

}  // namespace odomd::tools
