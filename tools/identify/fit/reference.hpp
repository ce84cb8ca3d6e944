// The way of a car through noisy poses, smooth enough to be held against a filter's speed.
#pragma once

#include <span>

#include "estimator/common/measurement.hpp"
#include "tools/drive_files/trajectory.hpp"

namespace odomd::tools::fitting {

/// A cubic laid through the poses `half` seconds around each time, every 20 ms; poses far off it
/// lose their weight. Where poses are too few for one, there is no point. Poses in the order of
/// capture.
[[nodiscard]] Trajectory smoothed(std::span<const estimator::CameraPose> poses, double half);

}  // namespace odomd::tools::fitting
