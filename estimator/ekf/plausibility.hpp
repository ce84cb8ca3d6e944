// How samples of each source are judged, and compared with earlier ones, without using the state of
// the filter. A jump that no car can make may be a corrupt frame, so a second consistent sample is
// needed.
//
// docs/model.md, "Gates and rejection timeouts".
#pragma once

#include <cstdint>

#include "estimator/common/vehicle.hpp"
#include "estimator/ekf/process_model.hpp"
#include "estimator/ekf/sample_window.hpp"
#include "estimator/ekf/state.hpp"

namespace odomd::estimator::full {

/// A source without a fused sample for this long is silent [s].
inline constexpr double silence_s = 1.0;

/// A longer gap between two samples does not widen a gate any further [s].
inline constexpr double longest_gap_s = 0.2;

/// How the samples of a source are judged.
struct Rules {
  double Tuning::*gate;  ///< threshold of ν²/S
  double timeout_s;      ///< samples rejected for this long are accepted
  at::Index inflated;    ///< state whose variance grows then
  bool turn;             ///< its samples measure a turn and do not correct the speed
  /// Two samples are consistent if |z_2 - z_1| ≤ at_once + share |z| + rate Δt, share |z| at most
  /// 2. This allows for kerbs, and for the wheels of one axle in a tight turn.
  double at_once, share, rate;  ///< at_once [unit], rate [unit/s]
};
[[nodiscard]] constexpr Rules rules_of(Source source) noexcept {
  switch (source) {
    case Source::yaw_rate:
      return {&Tuning::signal_gate,        0.05, at::yaw_rate, true, 0.5, 0.0,
              integrity::largest_yaw_accel};
    case Source::accel_y:
      return {&Tuning::signal_gate, longest_gap_s, at::accel_bias_y, true, 10.0, 0.0, 100.0};
    case Source::accel_x:
      // A longer timeout: a car that sets off accelerates before its wheels resolve the speed.
      return {&Tuning::signal_gate, 1.5, at::accel_bias_x, false, 10.0, 0.0, 100.0};
    default:
      return {&Tuning::wheel_gate, 0.1, at::v_x, false, 0.3, 0.3, 10.0};
  }
}

/// Longest cycle at which a decision waits for the next sample [s].
inline constexpr double next_sample_s = 0.05;

/// Number of consecutive earlier samples that are consistent with this one, from the same source
/// (for a wheel: from any wheel).
[[nodiscard]] int consistent_samples(const State& state, const Sample& sample) noexcept;

/// Whether the sample is the first of its source, or the first after a pause of more than a few
/// cycles and more than `at_least_s` [s].
[[nodiscard]] bool ends_pause(const State& state, const Sample& sample,
                              double at_least_s = 0.0) noexcept;

/// The median of the wheels' first speeds, and the number of samples, at most five per wheel.
struct FirstSpeeds {
  double median = 0.0;  ///< [m/s]
  std::size_t samples = 0;
};
[[nodiscard]] FirstSpeeds first_speeds(const State& state) noexcept;

/// Time of the earliest wheel sample that is consistent with this one; its own time if none is.
[[nodiscard]] std::int64_t consistent_since_ns(const State& state, const Sample& sample) noexcept;

/// Turning and still wheels, from the newest sample of each within 0.25 s, including `sample`. A
/// still wheel does not count if its dead band hides the speed of a wheel with a smaller dead band.
struct WheelCount {
  int turning = 0;
  int still = 0;
  bool free_turning = false;  ///< an undriven wheel turns
  bool free_still = false;
  double slowest = 0.0;  ///< speed of the slowest turning wheel [m/s]
};
[[nodiscard]] WheelCount count_wheels(Driven driven, const State& state,
                                      const Sample& sample) noexcept;

/// The smallest dead band of the wheels that have samples; without any, the largest of all [m/s].
[[nodiscard]] double smallest_dead_band(const State& state) noexcept;

/// Whether a wheel has had a sample lately.
[[nodiscard]] bool is_current(const State& state, Source wheel, std::int64_t time_ns) noexcept;

/// Whether a camera or a trusted undriven wheel measures v_x, even in a slide.
[[nodiscard]] bool knows_speed(Driven driven, const State& state) noexcept;

/// The largest slip of a rear wheel relative to |v_x|, at most 1: a spinning or locked tyre
/// has less lateral grip.
[[nodiscard]] double rear_spin(const Vehicle& car, const State& state) noexcept;

/// Time of the last fused sample of any wheel; 0: never.
[[nodiscard]] std::int64_t last_wheel_ns(const State& state) noexcept;

/// Time for which the wheels have been silent beyond their cycle [s].
[[nodiscard]] double wheel_silence_s(const State& state, std::int64_t time_ns) noexcept;

/// A wheel that stands for this long while another one turns is dead [s].
inline constexpr double dead_after_s = 0.5;

/// Stores the sample as the newest one of its source.
void note_reading(State& state, const Sample& sample) noexcept;

/// Applies a sample of the direction, the sign of unsigned wheel speeds; the sign may have been
/// wrong until now. 0 (unknown) keeps the last direction until the car may have stopped. Returns
/// `gated` for a single reversal that is too fast for a car.
[[nodiscard]] Verdict take_direction(const CarModel& model, State& state,
                                     const Sample& sample) noexcept;

/// Whether a cyclic direction signal has stopped arriving, and the car may have stood since, so
/// that it may set off in either direction.
[[nodiscard]] bool lost_direction(const State& state) noexcept;

}  // namespace odomd::estimator::full
