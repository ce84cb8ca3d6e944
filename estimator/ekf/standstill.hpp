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

/// Whether a turning wheel ends the standstill. Most wheels must turn: two of them, or one whose
/// last sample is consistent or not recent. Or half of them for so long that the others must be
/// dead. Driven wheels that spin alone do not move a car.
[[nodiscard]] bool sets_off(State& state, const Sample& sample, const WheelCount& wheels) noexcept;

/// The car stands when no wheel has turned for this long [s].
inline constexpr double standing_after_s = 0.3;

/// Whether a wheel that measures `speed` with the noise `sigma` turns.
[[nodiscard]] bool is_turning(double speed, double sigma) noexcept;

/// Call it with a wheel that does not turn at `time_ns` while most wheels do not: begins a still
/// period, or a standstill after it. `wheels_still = false` ends the period.
void update_standstill_by_wheels(State& state, std::int64_t time_ns) noexcept;

/// A gyro reading that moves, or is far from a known bias, ends the still period. One that stays
/// there for seconds is accepted as a new bias.
void update_standstill_by_gyro(const CarModel& model, State& state, std::int64_t time_ns,
                               double yaw_rate, double sigma) noexcept;

}  // namespace odomd::estimator::full
