// The fit's cost functions for Ceres.
#pragma once

#include <ceres/cost_function.h>

#include <array>
#include <memory>

#include "tools/identify/fit/solver.hpp"
#include "tools/identify/fit/window.hpp"

namespace odomd::tools::fitting {

/// Blocks: the parameters, a window's first node, its inside, the next window's node.
/// Refers to the setup and the window.
[[nodiscard]] std::unique_ptr<ceres::CostFunction> window_cost(
    const Setup& setup, const Window& window, const std::array<bool, parameters>& free);

/// Block: the parameters.
[[nodiscard]] std::unique_ptr<ceres::CostFunction> prior_cost(const Settings& settings);

}  // namespace odomd::tools::fitting
