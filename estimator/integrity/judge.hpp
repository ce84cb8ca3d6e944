// A scalar sample against what the state makes of it: the gate, and a source that insists.
#pragma once

#include <cstdint>

#include "estimator/ekf/prediction.hpp"
#include "estimator/ekf/sample_window.hpp"
#include "estimator/ekf/state.hpp"

namespace odomd::estimator::full {

/// So long at most a correction of the velocity reaches back into the pose [s].
inline constexpr double longest_unheard_s = 0.2;

/// When one of the same kind was last fused, 0: never. Wheels vouch for each other.
[[nodiscard]] std::int64_t last_fused_ns(const State& state, Source source) noexcept;

/// Fuses the sample where ν²/S <= gate; or where its source has been rejected for so long that the
/// filter gives in, after doubting what it measures by as much as the sample is off.
[[nodiscard]] Judgement judge(double gate, State& state, const Sample& sample,
                              const Prediction& prediction, Teaches teaches) noexcept;

}  // namespace odomd::estimator::full
