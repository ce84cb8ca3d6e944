// What the fit's model leaves out of a car, as uncertainties of its parameters.
#pragma once

#include "tools/identify/fit_parameters.hpp"
#include "tools/identify/fit_solver.hpp"

namespace odomd::tools::fitting {

/// Whether turns were driven at too few speeds: Turns::speed_variety.
[[nodiscard]] bool at_one_speed(double wheelbase, const Settings& settings, double variety);

/// Standard uncertainties of p beside what the residuals tell.
[[nodiscard]] Numbers<double> allowance(double wheelbase, const Settings& settings, double variety);

}  // namespace odomd::tools::fitting
