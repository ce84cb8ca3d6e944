// What no car does, of any size: a sample beyond is a broken sensor or a wrong scale.
#pragma once

#include <array>

#include "estimator/measurement.hpp"

namespace odomd::estimator {

/// Largest magnitudes, in the order of Source.
inline constexpr std::array<double, source_count> physical_limit{
    35.0,                        // yaw_rate [rad/s]
    200.0, 200.0,                // accel_x, accel_y [m/s²]
    150.0, 150.0, 150.0, 150.0,  // wheels [m/s]
    150.0, 150.0,                // wheel_rear, motor [m/s]
    1.4,                         // steering [rad], short of the tangent's pole
    1.0,                         // direction
    0.0,                         // camera: not a signal
};

}  // namespace odomd::estimator
