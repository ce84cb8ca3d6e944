// A reference whose times are off: by tens of milliseconds nothing looks wrong but the errors,
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

/// By position and heading over the whole drive, of an estimate that stays with the reference:
/// nothing where the errors have other reasons. Nothing below 20 ms and beyond 0.23 s.
[[nodiscard]] std::optional<TimeOffset> offset_by_positions(const Trajectory& reference,
                                                            const Trajectory& estimate,
                                                            Align align);

/// By way and turn over every second, of an estimate that may drift; the errors are those over a
/// second. A model that turns by its steering turns before the car does, and is not taken for an
/// offset.
[[nodiscard]] std::optional<TimeOffset> offset_by_motion(const Trajectory& reference,
                                                         const Trajectory& estimate);

}  // namespace odomd::tools
