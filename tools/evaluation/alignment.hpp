// Poses against a reference: the alignment of the two frames, and the error of each pose.
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

/// Aligned estimate - reference.
struct PoseError {
  std::int64_t t_ns = 0;
  estimator::Pose2 error;                  ///< in the axes of the map [m, m, rad], yaw accumulated
  double heading = 0.0;                    ///< of the reference [rad]
  estimator::PoseCovariance covariance{};  ///< of the estimate and of a camera's noise, likewise
  std::optional<double> nees;              ///< eᵀP⁻¹e; nothing if P is not positive definite
};

/// Whether the covariances of an estimate apply to its errors after the alignment. Aligned at the
/// first time, the uncertainty of the start is removed: they apply only if that is a small part (1
/// %) of the covariance at the end. After a fit to all positions they never apply.
[[nodiscard]] bool covariance_is_of_error(std::span<const Pair> pairs, Align align);

/// Both headings are unwrapped; whole turns between them are removed at the first time and at
/// resets of the estimate, which cannot know the number of turns. Without a covariance the last two
/// members stay empty.
[[nodiscard]] std::vector<PoseError> pose_errors(std::span<const Pair> pairs,
                                                 const estimator::Pose2& alignment,
                                                 bool has_covariance);

/// The same along the reference's heading and across it, with the standard deviations there.
struct DrivenError {
  double along = 0.0;  ///< ahead of the reference [m]
  double cross = 0.0;  ///< to the left of it [m]
  double yaw = 0.0;    ///< [rad]
  double sigma_along = 0.0;
  double sigma_cross = 0.0;
  double sigma_yaw = 0.0;
};
[[nodiscard]] DrivenError driven(const PoseError& error);

/// 95 % of νᵀP⁻¹ν with three degrees of freedom lie below.
inline constexpr double chi_squared_95_of_3 = 7.814727903251179;

}  // namespace odomd::tools
