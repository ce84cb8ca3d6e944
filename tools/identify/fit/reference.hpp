// The path of a car from noisy poses, smooth enough to compare with a filter's speed.
#pragma once

#include <span>

#include "estimator/common/measurement.hpp"
#include "tools/drive_files/trajectory.hpp"

namespace odomd::tools::fitting {

/// A cubic fitted to the poses `half` seconds around each time, every 20 ms; outliers lose their
/// weight. There is no point if poses are too few. Poses in the order of capture.
[[nodiscard]] Trajectory smoothed(std::span<const estimator::CameraPose> poses, double half);

}  // namespace odomd::tools::fitting
