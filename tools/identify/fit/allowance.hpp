// What the fit's model leaves out of a car, as uncertainties of its parameters.
#pragma once

#include <optional>

#include "tools/identify/fit/parameters.hpp"
#include "tools/identify/fit/solver.hpp"

namespace odomd::tools::fitting {

/// Whether turns were driven at too few speeds to tell apart what is free and not known before.
/// `wheelbase` in m, `variety`: Turns::speed_variety.
[[nodiscard]] bool at_one_speed(double wheelbase, const Settings& settings, double variety);

/// The parameter that k looks like at one speed, where both are open.
[[nodiscard]] std::optional<Parameter> twin(double wheelbase, const Settings& settings,
                                            double variety, Parameter k);

/// Standard uncertainties of p beside what the residuals tell, in the units of p: shares of
/// factors, SI of shifts.
[[nodiscard]] Numbers<double> allowance(double wheelbase, const Settings& settings, double variety);

}  // namespace odomd::tools::fitting
