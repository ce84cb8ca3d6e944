// The camera: z = (X, Y, ψ) at the instant the picture was taken, judged as a whole, and what is
// done when the filter is wrong and the camera right.
#pragma once

#include "estimator/ekf/process.hpp"
#include "estimator/ekf/sample_window.hpp"
#include "estimator/ekf/state.hpp"

namespace odomd::estimator::full {

/// So many rejected poses in a row are believed after all: that agree with how the filter goes, or
/// that a car could have come through, however the filter thinks it goes. Where wheels spin the
/// filter knows nothing better.
inline constexpr int believed_rejections = 6;

/// So long the wheels are doubted when the camera has shown the car to go otherwise: what is known
/// best to err is a wheel that slips [s].
inline constexpr double wheels_doubted_s = 2.0;

struct CameraGate {
  double gate = 16.27;  ///< χ² with 3 degrees of freedom, 99.9 %
  bool locates = true;  ///< the first pose may initialise the filter
};

/// ν = z - (X, Y, ψ), S = P + R; fused where νᵀS⁻¹ν <= gate. Poses that are rejected are held
/// against each other: where the motion along them is the filter's or a car's, six in a row, and of
/// a slow car as many as tell it from a picture that stands still, move the filter's pose to the
/// last of them (`resets`, `last_jump`). Velocity and gyro bias are doubted a little, and where the
/// motion was not the filter's, it is the poses'. A picture that stands still while the car drives
/// is no such run; a car that had to be moved does not stand, whatever its wheels say. The state is
/// that at the time of the sample.
[[nodiscard]] Judgement take_camera(const CarModel& model, const CameraGate& gate, State& state,
                                    const Sample& sample) noexcept;

}  // namespace odomd::estimator::full
