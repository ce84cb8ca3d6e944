// Standing still: when no wheel turns and the gyro is quiet for long enough, the velocity is zero
// and known to be, the pose is held, and whatever the inertial sensors say is their bias.
#pragma once

#include "estimator/ekf/process.hpp"
#include "estimator/ekf/state.hpp"

namespace odomd::estimator::full {

/// So much a car that has set off unseen has gained, one sigma [m/s²].
inline constexpr double brisk_accel = 1.0;

/// Ends a standstill: the car goes at most at this speed [m/s], and has gained it unseen.
void set_off(const CarModel& model, State& state, double speed) noexcept;

/// So long no wheel turns before the car is taken to stand [s].
inline constexpr double standing_after_s = 0.3;

/// Whether a wheel that reads `speed`, its noise `sigma`, turns.
[[nodiscard]] bool is_turning(double speed, double sigma) noexcept;

/// A wheel that does not turn was heard at `time_ns`, and most do not: begins a rest, or ends one
/// in a standstill. `state.standstill.wheels_still = false` ends a rest.
void update_standstill_by_wheels(State& state, std::int64_t time_ns) noexcept;

/// A gyro's sample: a rest during which it swings is none, and no car stands whose gyro is far from
/// a bias that is known, unless it stays there for seconds.
void update_standstill_by_gyro(const CarModel& model, State& state, std::int64_t time_ns,
                               double yaw_rate, double sigma) noexcept;

}  // namespace odomd::estimator::full
