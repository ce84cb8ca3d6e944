// Errors of an estimate against a reference, or, for a lap that ends where it began, against its
// own start. docs/evaluation.md has every definition.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "daemon/diagnostics/diagnostic.hpp"
#include "estimator/common/estimate.hpp"
#include "tools/drive_files/trajectory.hpp"
#include "tools/evaluation/pose_error.hpp"

namespace odomd::tools {

/// What an estimate is compared with.
enum class Against : std::uint8_t {
  reference,
  camera,       ///< the camera's next poses: see drive_evaluation.hpp
  closed_loop,  ///< its own start
  nothing,      ///< the error is not known; innovations only
};

/// Whether the errors at every time are known.
[[nodiscard]] constexpr bool has_reference(Against against) {
  return against == Against::reference || against == Against::camera;
}

struct Consistency {
  double nees = 0.0;       ///< mean of eᵀP⁻¹e over (x, y, yaw); 3 if the sigmas are consistent
  double inside_95 = 0.0;  ///< share below χ²₉₅
  std::size_t samples = 0;
};

struct Evaluation {
  std::string name;  ///< of the pose file, or of the model
  Against against = Against::reference;
  std::int64_t first_ns = 0;
  std::int64_t last_ns = 0;
  std::size_t samples = 0;
  double path_length = 0.0;           ///< of the reference, or of the estimate in a closed loop [m]
  double farthest = 0.0;              ///< largest distance of that path from its start [m]
  std::size_t reference_jumps = 0;    ///< number of steps faster than any car: over 100 m/s
  std::int64_t reference_gap_ns = 0;  ///< longest gap that was interpolated
  std::int64_t reference_stuck_ns = 0;  ///< total time at one position while the estimate moves on
  estimator::Pose2 alignment;           ///< of the estimate to the reference

  // Also for a closed loop:
  double end_error = 0.0;              ///< [m]
  std::optional<double> end_cm_per_m;  ///< per path length; nothing if stationary
  double heading_end = 0.0;            ///< accumulated, estimate - reference [rad]

  // Only with a reference. With a camera as reference, its noise is part of mean and max, but not
  // of rms:
  Spread position;                         ///< [m]
  Spread heading;                          ///< [rad]
  double reference_noise = 0.0;            ///< rms of a camera's positions [m]
  std::vector<HorizonError> horizons;      ///< those within the time span
  std::optional<Consistency> consistency;  ///< if the estimate has sigmas; with a camera's noise
  std::optional<estimator::BodyVelocity>
      velocity_rms;  ///< if both have velocities: rms of each difference

  /// For a replay whose model tests its samples, with or without a reference: factor by which mean
  /// NIS / dimension differs from 1, up or down; geometric mean over the sources. 1 is consistent.
  std::optional<double> nis_factor;
};

/// The error over a horizon; null if it is not known.
[[nodiscard]] const HorizonError* error_over(const Evaluation& e, std::int64_t horizon_ns);

/// Throws std::invalid_argument if there are fewer than two common times.
[[nodiscard]] Evaluation evaluate(const Trajectory& reference, const Trajectory& estimate,
                                  Align align);

/// The estimate in the frame of the reference.
[[nodiscard]] Trajectory aligned(const Trajectory& estimate, const estimator::Pose2& alignment);

/// End error and end heading (to the nearest whole turn) of an estimate of a closed lap, with its
/// own path length. Figures that need a reference stay empty. Throws std::invalid_argument for
/// fewer than two rows.
[[nodiscard]] Evaluation evaluate_closed_loop(const Trajectory& estimate);

/// Whether to assume a closed lap without --closed-loop: the estimate ends within 3 % of the path
/// and 20° of its start, which its own drift may explain.
[[nodiscard]] bool closes(const Evaluation& loop);

/// The evaluation of a drive whose errors are not known.
[[nodiscard]] Evaluation without_errors(const Evaluation& open);

/// Checks with the best estimate that the car came back. Throws std::invalid_argument if it moved
/// less than 1 m, or if start and end differ by over 45°, a tenth of the path, or half the farthest
/// distance. Over 3 % of the path or 20° gives a diagnostic: estimate or car may be off.
[[nodiscard]] std::optional<diagnostics::Diagnostic> check_that_it_closes(
    const std::string& drive, std::span<const Evaluation> evaluations);

}  // namespace odomd::tools
