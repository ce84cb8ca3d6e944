// Whether a reading can be believed beside the one before it, whatever the filter holds: what no
// car does between two samples is no motion. A telegram that is wrong in spite of its checksum, or
// the first after a silence, thereby needs a second one that says the same.
#pragma once

#include <cstdint>

#include "estimator/common/vehicle.hpp"
#include "estimator/ekf/sample_window.hpp"
#include "estimator/ekf/state.hpp"

namespace odomd::estimator::full {

/// A source that none was fused of for so long is silent [s].
inline constexpr double silence_s = 1.0;

/// A source that is heard less often is not waited for [s].
inline constexpr double next_sample_s = 0.05;

/// How many readings of the sample's source in a row, up to the one before it, can be of one motion
/// with it; of a wheel, of whichever wheel says most for it. What is allowed from one to the next
/// is in the .cpp.
[[nodiscard]] int consistent_samples(const State& state, const Sample& sample) noexcept;

/// When the first of those wheels was heard that agree with a wheel's sample; its own time where
/// none does.
[[nodiscard]] std::int64_t consistent_since_ns(const State& state, const Sample& sample) noexcept;

/// What the wheels say that were heard in the last quarter of a second, each by its newest reading,
/// a wheel's sample among them.
struct WheelCount {
  int turning = 0;
  int still = 0;
  bool free_turning = false;  ///< one that is not driven is among them
  bool free_still = false;
  double slowest = 0.0;  ///< of those that turn [m/s]
};
[[nodiscard]] WheelCount count_wheels(Driven driven, const State& state,
                                      const Sample& sample) noexcept;

/// When the newest sample of a wheel was fused; 0: never.
[[nodiscard]] std::int64_t last_wheel_ns(const State& state) noexcept;

/// A wheel that rests for so long beside one that turns is dead [s].
inline constexpr double dead_after_s = 0.5;

/// Notes what the source has said, after the sample was taken.
void note_reading(State& state, const Sample& sample) noexcept;

}  // namespace odomd::estimator::full
