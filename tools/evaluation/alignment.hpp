// Alignment of an estimate's frame with the reference's, and of the point that each follows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "estimator/common/estimate.hpp"
#include "tools/drive_files/trajectory.hpp"

namespace odomd::tools {

enum class Align : std::uint8_t {
  first,  ///< position and heading agree at the first common time
  fit,    ///< least squares of the positions over all common times
  none,   ///< the poses as they are
};

/// An estimate and the reference at one common time.
struct Pair {
  TrajectoryPoint estimate;
  TrajectoryPoint reference;  ///< its covariance is a camera's noise, else 0
};

/// The pairs at common times: the estimate's rows within the span of the reference, which is
/// interpolated. Throws std::invalid_argument if there are fewer than two.
[[nodiscard]] std::vector<Pair> common_times(const Trajectory& reference,
                                             const Trajectory& estimate);

/// The rigid motion T from the frame of the estimate to that of the reference: T ∘ estimate.
[[nodiscard]] estimator::Pose2 alignment(std::span<const Pair> pairs, Align align);

/// Converts a reference that follows a point at `lever_arm` (its pose in the body frame) into one
/// of the centre of gravity: pose ∘ lever_arm⁻¹, velocities likewise.
[[nodiscard]] Trajectory at_centre_of_gravity(const Trajectory& reference,
                                              const estimator::Pose2& lever_arm);

struct LeverArmFit {
  estimator::Pose2 lever_arm;
  std::size_t windows = 0;  ///< number of one-second windows used for the fit
};

/// Fits one lever arm of the reference to all estimates, from displacements over a second: drift
/// and alignment do not affect them, and a scale error of the estimates is fitted too. Throws
/// std::invalid_argument if the drive turns too little.
[[nodiscard]] LeverArmFit fit_lever_arm(const Trajectory& reference,
                                        std::span<const Trajectory> estimates);

}  // namespace odomd::tools
