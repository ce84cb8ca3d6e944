// The results of a fit as numbers of the configuration, each combined with the present value.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "tools/identify/common/car_model.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/identify/fit/parameters.hpp"
#include "tools/identify/fit/solver.hpp"

namespace odomd::tools::fitting {

[[nodiscard]] Findings findings_of(const daemon::Config& config, std::span<const FitDrive> drives,
                                   const Settings& settings, const Result& result);

// Model errors of the fit, as uncertainties of its parameters.

/// Whether turns were driven at too few speeds to separate free parameters without a good prior.
/// `wheelbase` in m, `variety`: Turns::speed_variety.
[[nodiscard]] bool at_one_speed(double wheelbase, const Settings& settings, double variety);

/// The parameter that cannot be separated from k at one speed, if neither is known well.
[[nodiscard]] std::optional<Parameter> twin(double wheelbase, const Settings& settings,
                                            double variety, Parameter k);

/// Standard uncertainties of p in addition to those from the residuals, in the units of p: relative
/// for factors, SI for shifts.
[[nodiscard]] Numbers<double> allowance(double wheelbase, const Settings& settings, double variety);

// Brush tyres of the filter that match the fitted tyres (docs/model.md, "Tyres").

enum class Axle : std::uint8_t { front, rear };

struct BrushTyre {
  double stiffness = 0.0;  ///< C, of the whole axle at zero slip [N/rad]
  double grip = 0.0;       ///< F_max / the axle's share of the mass [m/s²]
};

/// The slip angle [rad] of an axle in a steady turn of this lateral acceleration [m/s²], above 0.
/// Infinite if it cannot carry its share of the car, or slips by more than 45°.
[[nodiscard]] double slip_at(const car_model::Car<double>& car, Axle axle, double accel);

/// The brush tyre with the same slip as the axle at this lateral acceleration [m/s²] and at half of
/// it. Nothing if the axle does not saturate, or cannot reach that acceleration.
[[nodiscard]] std::optional<BrushTyre> brush_like(const car_model::Car<double>& car, Axle axle,
                                                  double accel);

}  // namespace odomd::tools::fitting
