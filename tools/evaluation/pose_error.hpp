// The error of an estimate at every common time, also along and across the heading.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "estimator/common/estimate.hpp"
#include "tools/evaluation/alignment.hpp"

namespace odomd::tools {

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
