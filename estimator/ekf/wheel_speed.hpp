// A wheel, an axle or the motor: the ground speed of its contact point along the wheel.
#pragma once

#include <cmath>

#include "estimator/ekf/model.hpp"
#include "estimator/ekf/prediction.hpp"

namespace odomd::estimator::full {

/// How far wheels depart from rolling.
struct WheelNoise {
  double radius = 0.0025;     ///< by how much one wheel's radius differs from the others', relative
  double driven_slip = 0.02;  ///< slip of a driven wheel per acceleration [1/(m/s²)]
  double free_slip = 0.01;    ///< the same of a wheel that only brakes
  double front_angle = 0.05;  ///< how well δ is known [rad]
};

/// Whether a source's wheel drives the car: that of the rear axle, and the motor.
[[nodiscard]] constexpr bool is_driven(Source source) noexcept {
  return source != Source::wheel_front_left && source != Source::wheel_front_right;
}

/// Where a source's wheel is: ahead of the centre of gravity, left of it [m]; steered.
struct WheelPlace {
  double ahead = 0.0;
  double left = 0.0;
  bool steered = false;
};
[[nodiscard]] WheelPlace wheel_place(const Vehicle& car, Source source) noexcept;

/// z = (1 + s_w) (u cos δ + w sin δ), with u = v_x - y_w ψ̇ and w = v_y + x_w ψ̇ the velocity of the
/// wheel's place (x_w, y_w); δ = 0 at the rear.
///
/// The filter learns v_x and s_w from it. That the two wheels of an axle differ says little about
/// ψ̇ (a radius 0.3 % larger makes 0.03 rad/s of it at 1.5 m/s), and nothing about v_y: with a gyro
/// alive, those two count as known, with their variance. Without one (`gyro` false) ψ̇ is learnt.
/// Where `input` has no steering a front wheel is taken to roll where the middle of its axle goes.
[[nodiscard]] Prediction predict_wheel_speed(const CarModel& model, const WheelNoise& noise,
                                             const Input& input, const State& state, Source source,
                                             double sigma, bool gyro) noexcept;

}  // namespace odomd::estimator::full
