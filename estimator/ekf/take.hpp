// Applies one sample to the state at its time: plausibility, gate, update, standstill. A pure
// function of state and sample, so that a window can be replayed. A camera pose z = (X, Y, ψ)
// is applied at its capture time, as a whole; the filter recovers when it is wrong and the camera
// is right.
//
// docs/model.md, "Process".
#pragma once

#include "estimator/ekf/process_model.hpp"
#include "estimator/ekf/sample_window.hpp"
#include "estimator/ekf/state.hpp"

namespace odomd::estimator::full {

/// Number of consecutive fused poses that confirm the pose.
inline constexpr int poses_to_confirm = 6;

struct CameraGate {
  double gate = FilterSettings{}.camera_gate;  ///< χ² with 3 degrees of freedom, 99.9 %
  bool locates = true;                         ///< the first pose initialises the filter
};

/// The constants of a filter.
struct Context {
  CarModel model;
  CameraGate camera;
  double period_s = FilterSettings{}.period_s;
};

/// Propagates the state to `time_ns`, in steps of at most one and a half periods.
void advance(const Context& context, State& state, std::int64_t time_ns) noexcept;

/// The model's inputs at the state's time, unless they are too old.
[[nodiscard]] Input input_of(const State& state) noexcept;

/// Applies a sample whose time is the state's.
[[nodiscard]] Judgement take(const Context& context, State& state, const Sample& sample) noexcept;

/// Updates the camera's noise scale with any pose, fused or not.
void note_camera_pose(State& state, const Sample& pose) noexcept;

/// ν = z - (X, Y, ψ), S = P + R; fused if νᵀS⁻¹ν <= gate. A pose beyond the gate is an outlier, or
/// the filter is wrong: the log odds accumulate from pose to pose. Once they favour the camera, P
/// is widened by ν and the pose is fused with its correlations (`resets`, `last_jump`). The state
/// is at the time of the sample; `before` is the previous camera pose.
[[nodiscard]] Judgement take_camera(const CarModel& model, const CameraGate& gate, State& state,
                                    const PosePair& before, const Sample& sample) noexcept;

/// Checks the sources, takes back the effect of a faulty source on the pose, and resets the motion
/// to the consensus if the filter has deviated from it for a while.
void apply_integrity(const Context& context, State& state) noexcept;

}  // namespace odomd::estimator::full
