// Detects a reference with wrong times. An offset of tens of milliseconds shows only in errors like
// those of a bad filter with far too small sigmas.
#pragma once

#include <optional>

#include "tools/drive_files/trajectory.hpp"
#include "tools/evaluation/pose_error.hpp"

namespace odomd::tools {

struct TimeOffset {
  double late_s = 0.0;  ///< offset of the reference's times; negative: early
  double before = 0.0;  ///< rms error with the times as they are [m]
  double after = 0.0;   ///< rms error without the offset [m]
};

/// From position and heading over the whole drive, for an estimate that does not drift from the
/// reference. Nothing if errors have other causes, or the offset is below 20 ms or above 0.23 s.
[[nodiscard]] std::optional<TimeOffset> offset_by_positions(const Trajectory& reference,
                                                            const Trajectory& estimate,
                                                            Align align);

/// From displacement and yaw change over every second, for an estimate that may drift; the errors
/// are those over a second. A model that turns with the steering does so before the car; this is
/// not taken for an offset.
[[nodiscard]] std::optional<TimeOffset> offset_by_motion(const Trajectory& reference,
                                                         const Trajectory& estimate);

}  // namespace odomd::tools
