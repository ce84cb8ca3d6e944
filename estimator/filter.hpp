// The filter that a configuration chose, behind four calls. A value: copying one copies its whole
// state. No clock, no I/O, no heap: every call is real-time safe and noexcept.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <variant>

#include "estimator/estimate.hpp"
#include "estimator/kinematic_filter.hpp"
#include "estimator/measurement.hpp"
#include "estimator/model.hpp"
#include "estimator/paper_filter.hpp"
#include "estimator/settings.hpp"
#include "estimator/vehicle.hpp"

namespace odomd::estimator {

/// One alternative per model. A richer filter joins here.
using Filter = std::variant<KinematicFilter, PaperFilter>;

/// Settings of all models are one struct; each takes its own.
[[nodiscard]] Filter make_filter(Model model, const FilterSettings& settings);

/// Sets the pose that the estimate starts from. Before this (or the first camera pose, where
/// `settings.initialise_from_camera`) step() returns estimates that are not initialised.
void set_initial_pose(Filter& filter, const Pose2& pose) noexcept;

/// Hands a measurement in, in any order within a tick. It takes effect at the next step().
Verdict add(Filter& filter, const Measurement& measurement) noexcept;
Verdict add(Filter& filter, const CameraPose& pose) noexcept;

/// Advances to the tick that is valid at `tick_ns` and says what is believed there. Ticks that were
/// skipped are made up for with the inputs held, at most 200 of them (a second).
Estimate step(Filter& filter, std::int64_t tick_ns) noexcept;

}  // namespace odomd::estimator
