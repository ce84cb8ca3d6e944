// The camera: z = (X, Y, ψ) at the capture time, gated as a whole; and the recovery when the filter
// is wrong and the camera is right.
//
// docs/model.md, "Camera".
#pragma once

#include "estimator/ekf/process.hpp"
#include "estimator/ekf/sample_window.hpp"
#include "estimator/ekf/state.hpp"

namespace odomd::estimator::full {

/// Number of consecutive fused poses that confirm the pose.
inline constexpr int poses_to_confirm = 6;

struct CameraGate {
  double gate = FilterSettings{}.camera_gate;  ///< χ² with 3 degrees of freedom, 99.9 %
  bool locates = true;                         ///< the first pose initialises the filter
};

/// Updates the camera's noise scale with any pose, fused or not.
void note_camera_pose(State& state, const Sample& pose) noexcept;

/// ν = z - (X, Y, ψ), S = P + R; fused if νᵀS⁻¹ν <= gate. A pose beyond it is an outlier, or the
/// filter is wrong: the log odds accumulate from pose to pose. Once they favour the camera, P is
/// widened by ν and the pose is fused with its correlations (`resets`, `last_jump`). The state is
/// at the time of the sample; `before` is the previous camera pose.
[[nodiscard]] Judgement take_camera(const CarModel& model, const CameraGate& gate, State& state,
                                    const PosePair& before, const Sample& sample) noexcept;

}  // namespace odomd::estimator::full
