// v_x from whatever wheel speeds there are. A rigid car has the same v_x at the rear axle and at
// the centre of gravity; a wheel beside the centre line sees the turn of the car on top of it.
#pragma once

#include <optional>

#include "estimator/baselines/held_signals.hpp"
#include "estimator/common/vehicle.hpp"

namespace odomd::estimator {

struct AxleSpeed {
  double v_x = 0.0;    ///< [m/s], forward positive
  double sigma = 0.0;  ///< [m/s]
};

/// A source that was silent for longer [s], while another of the wheels' was not, no longer counts.
inline constexpr double wheel_source_timeout_s = 0.5;

/// v_x, or nothing where no wheel was ever seen. The first of these that is alive counts:
///   both rear wheels      v_x = (v_rl + v_rr) / 2
///   the rear axle         v_x = v_r
///   one rear wheel        v_x = v_rl + ψ̇ t/2   or   v_rr - ψ̇ t/2              (t: track width)
///   the motor             v_x = v_motor
///   both front wheels     v_x = (v_fl + v_fr) / 2 · cos δ
///   one front wheel       v_x = v_fl cos δ + ψ̇ t/2   or   v_fr cos δ - ψ̇ t/2
/// A front wheel rolls along δ; cos δ takes its speed to the car's axis.
///
/// While the held direction is -1, positive speeds count as negative: those of sensors that do not
/// know a sign.
[[nodiscard]] std::optional<AxleSpeed> rear_axle_speed(const Vehicle& car, const HeldSignals& held,
                                                       double yaw_rate) noexcept;

}  // namespace odomd::estimator
