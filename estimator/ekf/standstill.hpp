// Start of the motion, and standstill: when no wheel turns and the gyro is constant for long
// enough, the velocity is zero, the pose is held, and the inertial sensors measure their biases
// (zero-velocity update).
//
// docs/model.md, "Standstill".
#pragma once

#include "estimator/ekf/plausibility.hpp"
#include "estimator/ekf/process_model.hpp"
#include "estimator/ekf/sample_window.hpp"
#include "estimator/ekf/state.hpp"

namespace odomd::estimator::full {

/// Acceleration that a car may have had since it set off unnoticed, one sigma [m/s²].
inline constexpr double brisk_accel = 1.0;

/// Ends a standstill. The car has reached at most `speed` [m/s] unnoticed.
void set_off(const CarModel& model, State& state, double speed) noexcept;

/// Starts the motion at the speed of a wheel's sample. Adds the distance since the first consistent
/// wheel sample, half of it as uncertainty. The distance from an earlier camera pose to that sample
/// is unknown.
void begin_motion(State& state, const Sample& sample) noexcept;

/// The first samples may be garbage: until there are five, a v_x far from their median is set to
/// it, and, before a camera pose, the position to where it leads. Call it at each wheel sample.
void correct_start(State& state, const Sample& sample) noexcept;

/// Whether a turning wheel ends the standstill. Either most wheels turn (at least two, or one that
/// earlier samples confirm), or half of them have turned for so long that the others must be dead.
/// Half is not enough if they are driven and all free wheels are still.
[[nodiscard]] bool sets_off(State& state, const Sample& sample, const WheelCount& wheels) noexcept;

/// Notes, at a wheel's sample, whether most wheels are still. The first such sample begins a still
/// period.
void note_wheels(State& state, const Sample& sample, bool still) noexcept;

/// Call it after each sample. A standstill begins when the evidence of all sources since the wheels
/// read 0 reaches odds of 100 : 1, and ends at 1 : 100. Time increases the odds; silent wheels,
/// a gyro off the known bias, a force, and a camera that sees the car move reduce them.
void update_standstill(const CarModel& model, State& state, const Sample& sample) noexcept;

/// Ends the standstill if the odds have fallen to 1 : 100, and returns whether it did.
bool doubt_standstill(const CarModel& model, State& state, std::int64_t time_ns) noexcept;

/// Two consecutive non-zero readings below a wheel's dead band lower the band to the larger
/// reading. The other single wheels with an equal dead band follow: their sensors are the same
/// unless configured otherwise.
void learn_dead_band(State& state, const Sample& sample) noexcept;

/// Learns the bias of a standing car's gyro. The filter notices a departure a little late, so a
/// stretch of samples counts only once the next stretch is over.
[[nodiscard]] Judgement take_still_gyro(const CarModel& model, State& state,
                                        const Sample& sample) noexcept;

}  // namespace odomd::estimator::full
