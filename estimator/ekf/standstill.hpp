// Start of the motion, and standstill: when no wheel turns and the gyro is constant for long
// enough, the velocity is zero, the pose is held, and the inertial sensors measure their biases
// (zero-velocity update).
//
// docs/model.md, "Standstill".
#pragma once

#include "estimator/ekf/plausibility.hpp"
#include "estimator/ekf/process.hpp"
#include "estimator/ekf/sample_window.hpp"
#include "estimator/ekf/state.hpp"

namespace odomd::estimator::full {

/// Acceleration that a car may have had since it set off unnoticed, one sigma [m/s²].
inline constexpr double brisk_accel = 1.0;

/// Ends a standstill. The car has reached at most `speed` [m/s] unnoticed.
void set_off(const CarModel& model, State& state, double speed) noexcept;

/// Starts the motion at the speed of a wheel's sample. The distance since the first consistent
/// wheel sample is added, half of it uncertain; all of that since the last camera pose before is
/// uncertain.
void begin_motion(State& state, const Sample& sample) noexcept;

/// The first samples may be garbage: until there are five, the speed is their median, and the car
/// has moved at that. Call it with every sample of a wheel.
void correct_start(State& state, const Sample& sample) noexcept;

/// Whether a turning wheel ends the standstill. Most wheels must turn: two of them, or one whose
/// last sample is consistent or not recent. Or half of them for so long that the others must be
/// dead. Driven wheels that spin alone do not move a car.
[[nodiscard]] bool sets_off(State& state, const Sample& sample, const WheelCount& wheels) noexcept;

/// Notes whether most wheels are still, at a wheel's sample. A still period begins with the first.
void note_wheels(State& state, const Sample& sample, bool still) noexcept;

/// Call it after each sample. The car stands if all sources since the wheels read 0 say so
/// together: at odds of 100 : 1, and until they are 1 : 100. A gyro that shows a bias which is not
/// its known one, a force and a camera that sees the car move speak against it; time speaks for it.
void update_standstill(const CarModel& model, State& state, const Sample& sample) noexcept;

/// A wheel that reads less than its dead band, twice, has a smaller one.
void learn_dead_band(State& state, const Sample& sample) noexcept;

/// The gyro of a standing car measures its bias. A car that sets off is noticed a little later, so
/// a stretch of samples counts only once the next one is over, too.
[[nodiscard]] Judgement take_still_gyro(const CarModel& model, State& state,
                                        const Sample& sample) noexcept;

}  // namespace odomd::estimator::full
