// The camera: z = (X, Y, ψ) at the capture time, gated as a whole; and the recovery when the filter
// is wrong and the camera is right.
//
// docs/model.md, "Camera".
#pragma once

#include "estimator/ekf/process.hpp"
#include "estimator/ekf/sample_window.hpp"
#include "estimator/ekf/state.hpp"

namespace odomd::estimator::full {

/// The filter accepts this many rejected poses in a row over this time, if they move as it does.
inline constexpr int rejections_to_accept = 6;
inline constexpr double rejection_timeout_s = 0.25;

struct CameraGate {
  double gate = 16.27;  ///< χ² with 3 degrees of freedom, 99.9 %
  bool locates = true;  ///< the first pose initialises the filter
};

/// Updates the camera's noise scale with any pose, fused or not.
void note_camera_pose(State& state, const Sample& pose) noexcept;

/// ν = z - (X, Y, ψ), S = P + R; fused if νᵀS⁻¹ν <= gate. A run of rejected poses that is
/// consistent with the filter's motion and the other sources resets the pose (`resets`,
/// `last_jump`). The state is that at the time of the sample.
[[nodiscard]] Judgement take_camera(const CarModel& model, const CameraGate& gate, State& state,
                                    const Sample& sample) noexcept;

}  // namespace odomd::estimator::full
