// Brings an estimate and a reference together: one rigid motion of the estimate into the frame of
// the reference, and the reference point of the truth moved to the centre of gravity.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "estimator/common/estimate.hpp"
#include "tools/drive_files/trajectory.hpp"

namespace odomd::tools {

enum class Align : std::uint8_t {
  first,  ///< position and heading agree at the first common time
  fit,    ///< least squares of the positions over all common times
  none,   ///< as they are
};

/// An estimate and the reference at one common time.
struct Pair {
  TrajectoryPoint estimate;
  TrajectoryPoint reference;  ///< its covariance is a camera's noise, else 0
};

/// The pairs at common times: the rows of the estimate within the span of the reference, with the
/// reference interpolated. Throws std::invalid_argument if there are fewer than two.
[[nodiscard]] std::vector<Pair> common_times(const Trajectory& reference,
                                             const Trajectory& estimate);

/// The rigid motion T that takes the estimate into the frame of the reference: T ∘ estimate.
[[nodiscard]] estimator::Pose2 alignment(std::span<const Pair> pairs, Align align);

/// Converts the reference of a point at `lever_arm` (its pose in the body frame) into that of the
/// centre of gravity: pose ∘ lever_arm⁻¹, velocities likewise.
[[nodiscard]] Trajectory at_centre_of_gravity(const Trajectory& reference,
                                              const estimator::Pose2& lever_arm);

struct LeverArmFit {
  estimator::Pose2 lever_arm;
  std::size_t windows = 0;  ///< number of one-second pieces that it was fitted to
};

/// Fits one lever arm of the reference to all estimates, by the displacements over a second (drift
/// and alignment have no part in them; a scale error of the estimate is fitted with it). Throws
/// std::invalid_argument if the drive turns too little.
[[nodiscard]] LeverArmFit fit_lever_arm(const Trajectory& reference,
                                        std::span<const Trajectory> estimates);

}  // namespace odomd::tools
