// How good an estimate is against a reference. docs/evaluation.md has every definition.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "estimator/estimate.hpp"
#include "tools/alignment.hpp"
#include "tools/trajectory.hpp"

namespace odomd::tools {

/// Over how long the relative displacement is judged: seven ticks of 5 ms.
inline constexpr std::int64_t short_horizon_ns = 35'000'000;

/// Of magnitudes.
struct Spread {
  double mean = 0.0;
  double rms = 0.0;
  double max = 0.0;
};

struct ShortTerm {
  Spread displacement;  ///< of the relative displacement in the body frame [m]
  Spread yaw;           ///< of the relative turn [rad]
  std::size_t samples = 0;
};

struct Consistency {
  double nees = 0.0;  ///< mean of eᵀP⁻¹e over (x, y, yaw); 3 where the sigmas are honest
  std::size_t samples = 0;
};

struct Evaluation {
  std::string name;  ///< of the pose file
  std::int64_t first_ns = 0;
  std::int64_t last_ns = 0;
  std::size_t samples = 0;
  double path_length = 0.0;           ///< of the reference between first and last [m]
  std::size_t reference_jumps = 0;    ///< steps of it that no car makes: over 100 m/s
  std::int64_t reference_gap_ns = 0;  ///< the longest that was interpolated across
  estimator::Pose2 alignment;         ///< of the estimate to the reference

  double end_error = 0.0;                  ///< [m]
  std::optional<double> end_cm_per_m;      ///< over the path; nothing where there is no path
  Spread position;                         ///< [m]
  double heading_end = 0.0;                ///< accumulated, estimate - reference [rad]
  Spread heading;                          ///< [rad]
  std::optional<ShortTerm> short_term;     ///< nothing where the span is shorter than the horizon
  std::optional<Consistency> consistency;  ///< where the estimate has sigmas
  std::optional<Motion> velocity_rms;      ///< where both have velocities: rms of each difference
};

/// Throws std::invalid_argument where the two have less than two times in common.
[[nodiscard]] Evaluation evaluate(const Trajectory& reference, const Trajectory& estimate,
                                  Align align);

/// The estimate in the frame of the reference.
[[nodiscard]] Trajectory aligned(const Trajectory& estimate, const estimator::Pose2& alignment);

}  // namespace odomd::tools
