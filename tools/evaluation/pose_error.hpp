// How far an estimate is off at every common time, in the axes that a driver thinks in.
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
  estimator::PoseCovariance covariance{};  ///< of the estimate, in the axes of the map
  std::optional<double> nees;  ///< eᵀP⁻¹e; nothing where P is not positive definite
};

/// Whether the covariances of an estimate are those of its errors once it is aligned. Aligned at
/// the first time it owes nothing for where it began: they are only where that is a small part (1
/// %) of what they are at the end. Fitted to the errors they never are.
[[nodiscard]] bool covariance_is_of_error(std::span<const Pair> pairs, Align align);

/// Both headings are unwrapped; whole turns between them are settled at the first time and where
/// the estimate was reset: it does not know how often the car has turned, and owes nothing for it.
/// Without a covariance the last two members stay empty.
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
