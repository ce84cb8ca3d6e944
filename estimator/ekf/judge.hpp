// A scalar sample against what the state makes of it: the gate, and a source that insists.
#pragma once

#include <cstdint>

#include "estimator/ekf/process.hpp"
#include "estimator/ekf/sample_window.hpp"
#include "estimator/ekf/state.hpp"
#include "estimator/ekf/update.hpp"

namespace odomd::estimator::full {

/// A sample that comes after a longer silence says nothing more of how the motion may change [s].
inline constexpr double longest_gap_s = 0.2;

/// When one of the same kind was last fused, 0: never. Wheels vouch for each other.
[[nodiscard]] std::int64_t last_fused_ns(const State& state, Source source) noexcept;

/// For how long the source's samples have all been refused, this one the last [s].
[[nodiscard]] double rejected_s(State& state, const Sample& sample) noexcept;

/// What a sample of the car's own sensors may correct_slow_errors.
struct Updates {
  bool heading = false;  ///< ψ, ψ̇ and ε: a gyro; without one, all
  SlowVector slow = none();
};

/// Fuses the sample where ν²/S is below the gate (S with what the motion may have changed by); or
/// where its source has been rejected for so long that the filter gives in, after doubting what it
/// measures by as much as the sample is off.
[[nodiscard]] Judgement judge(const CarModel& model, State& state, const Sample& sample,
                              const Prediction& prediction, const Updates& updates) noexcept;

}  // namespace odomd::estimator::full
