// The results of a fit as numbers of the configuration: each is combined with the present value.
#pragma once

#include <optional>
#include <span>

#include "tools/identify/common/finding.hpp"
#include "tools/identify/fit/parameters.hpp"
#include "tools/identify/fit/solver.hpp"

namespace odomd::tools::fitting {

/// `mass_sigma`: relative standard uncertainty of the configured mass. Only ratios to the mass show
/// in a drive, so it adds to the uncertainty of stiffnesses and inertia.
[[nodiscard]] Findings findings_of(const daemon::Config& config, std::span<const Drive> drives,
                                   const Settings& settings, const Result& result,
                                   double mass_sigma);

// Model errors of the fit, as uncertainties of its parameters.

/// Whether turns were driven at too few speeds to separate free parameters that are not known
/// before. `wheelbase` in m, `variety`: Turns::speed_variety.
[[nodiscard]] bool at_one_speed(double wheelbase, const Settings& settings, double variety);

/// The parameter that cannot be separated from k at one speed, if both are open.
[[nodiscard]] std::optional<Parameter> twin(double wheelbase, const Settings& settings,
                                            double variety, Parameter k);

/// Standard uncertainties of p in addition to those from the residuals, in the units of p: shares
/// for factors, SI for shifts.
[[nodiscard]] Numbers<double> allowance(double wheelbase, const Settings& settings, double variety);

}  // namespace odomd::tools::fitting
