// The results of a fit as numbers of the configuration: each is combined with the present value.
#pragma once

#include <span>

#include "tools/identify/common/finding.hpp"
#include "tools/identify/fit/solver.hpp"

namespace odomd::tools::fitting {

/// `mass_sigma`: relative standard uncertainty of the configured mass. Only ratios to the mass show
/// in a drive, so it adds to the uncertainty of stiffnesses and inertia.
[[nodiscard]] Findings findings_of(const daemon::Config& config, std::span<const Drive> drives,
                                   const Settings& settings, const Result& result,
                                   double mass_sigma);

}  // namespace odomd::tools::fitting
