// The camera: z = (X, Y, ψ) at the instant the picture was taken, judged as a whole, and what is
// done when the filter is wrong and the camera right.
#pragma once

#include "estimator/ekf/process.hpp"
#include "estimator/ekf/sample_window.hpp"
#include "estimator/ekf/state.hpp"

namespace odomd::estimator::full {

/// So many rejected poses in a row, over so long, are believed after all, if the last of them is
/// where the filter's way leads from the first.
inline constexpr int rejections_to_accept = 6;
inline constexpr double rejection_timeout_s = 0.25;

struct CameraGate {
  double gate = 16.27;  ///< χ² with 3 degrees of freedom, 99.9 %
  bool locates = true;  ///< the first pose may initialise the filter
};

/// Follows by how much the poses scatter, whether they are believed or not.
void note_camera_pose(State& state, const Sample& pose) noexcept;

/// ν = z - (X, Y, ψ), S = P + R; fused where νᵀS⁻¹ν <= gate. Poses that are rejected again and
/// again move the filter's pose to the last of them (`resets`, `last_jump`), if their motion is
/// that which the sources agree on. The state is that at the time of the sample.
[[nodiscard]] Judgement take_camera(const CarModel& model, const CameraGate& gate, State& state,
                                    const Sample& sample) noexcept;

}  // namespace odomd::estimator::full
