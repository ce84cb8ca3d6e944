// Detects a reference with wrong times. An offset of tens of milliseconds only shows in the errors,
// which look like those of a bad filter with sigmas that are much too small.
#pragma once

#include <optional>

#include "tools/drive_files/trajectory.hpp"
#include "tools/evaluation/alignment.hpp"

namespace odomd::tools {

struct TimeOffset {
  double late_s = 0.0;  ///< by how much the reference's times are late; negative: early
  double before = 0.0;  ///< rms of the error as the times are [m]
  double after = 0.0;   ///< and with this offset taken away
};

/// From position and heading over the whole drive, for an estimate that does not drift from the
/// reference. Nothing if the errors have other reasons, below 20 ms, and beyond 0.23 s.
[[nodiscard]] std::optional<TimeOffset> offset_by_positions(const Trajectory& reference,
                                                            const Trajectory& estimate,
                                                            Align align);

/// From distance and turn over every second, for an estimate that may drift; the errors are those
/// over a second. A model that turns by its steering turns before the car does; this is not taken
/// for an offset.
[[nodiscard]] std::optional<TimeOffset> offset_by_motion(const Trajectory& reference,
                                                         const Trajectory& estimate);

}  // namespace odomd::tools
