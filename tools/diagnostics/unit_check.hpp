// Detects poses of a camera or a reference in other units than metres and radians, which would make
// the wheels, the gyro or the drive look wrong.
#pragma once

#include <span>
#include <string>

#include "daemon/diagnostics/diagnostic.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/drive_files/trajectory.hpp"

namespace odomd::tools {

/// The motion that poses are compared with. Only its distances and turns matter, not its start.
struct Driven {
  const Trajectory& trajectory;
  std::string way_of = "the wheels";  ///< source of the distances, in messages
  std::string turn_of = "the gyro";
};

/// Reports poses of `subject` that go a hundred or a thousand times as far as driven, or turn 57
/// times as far. Empty if they do not, or if the drive is too short to decide.
[[nodiscard]] diagnostics::Diagnostics check_units(const std::string& subject,
                                                   std::span<const TrajectoryPoint> poses,
                                                   const Driven& driven);

/// The same for poses of a camera, in any order.
[[nodiscard]] diagnostics::Diagnostics check_units(const std::string& subject,
                                                   std::span<const estimator::CameraPose> poses,
                                                   const Driven& driven);

}  // namespace odomd::tools
