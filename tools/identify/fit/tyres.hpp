// The fitted tyres for the filter: a brush tyre for each axle (docs/model.md, "Tyres").
#pragma once

#include <cstdint>
#include <optional>

#include "tools/identify/fit/four_wheels.hpp"

namespace odomd::tools::fitting {

enum class Axle : std::uint8_t { front, rear };

struct BrushTyre {
  double stiffness = 0.0;  ///< C, of the whole axle at no slip [N/rad]
  double grip = 0.0;       ///< F_max by the axle's share of the mass [m/s²]
};

/// The slip angle [rad] at which an axle carries its share of the car in a steady turn of this
/// lateral acceleration [m/s²], above 0. Infinite if it cannot, or slips by more than 45°.
[[nodiscard]] double slip_at(const four_wheels::Car<double>& car, Axle axle, double accel);

/// The brush tyre that slips as the axle does at this lateral acceleration [m/s²] and at a half of
/// it. Nothing if the axle does not saturate, or cannot carry that.
[[nodiscard]] std::optional<BrushTyre> brush_like(const four_wheels::Car<double>& car, Axle axle,
                                                  double accel);

}  // namespace odomd::tools::fitting
