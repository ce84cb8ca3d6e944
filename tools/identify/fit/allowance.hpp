// Model errors of the fit, as uncertainties of its parameters.
#pragma once

#include <optional>

#include "tools/identify/fit/parameters.hpp"
#include "tools/identify/fit/solver.hpp"

namespace odomd::tools::fitting {

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
