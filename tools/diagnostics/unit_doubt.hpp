// Poses of a camera or a reference in other units than metres and radians: read like any other,
// they let the wheels, the gyro or the drive look wrong.
#pragma once

#include <span>
#include <string>

#include "estimator/common/measurement.hpp"
#include "tools/drive_files/trajectory.hpp"

namespace odomd::tools {

/// What poses are held against. Ways and turns count, wherever it begins.
struct Driven {
  const Trajectory& trajectory;
  std::string way_of = "the wheels";  ///< in messages
  std::string turn_of = "the gyro";
};

/// What to say of poses that go a hundred or a thousand times as far, or turn 57 times as far:
/// "x and y go about 1000 times as far as the wheels: are the positions in millimetres? they must
/// be metres". Empty where neither is so, and where too little is driven to tell.
[[nodiscard]] std::string unit_doubt(std::span<const TrajectoryPoint> poses, const Driven& driven);

/// The same of a camera's poses as they came, in any order.
[[nodiscard]] std::string unit_doubt(std::span<const estimator::CameraPose> poses,
                                     const Driven& driven);

}  // namespace odomd::tools
