// Poses of an estimate and a reference at common times: their alignment, the errors of each pose
// with its NEES, and of the motion over a given time.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
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

/// Aligned estimate - reference.
struct PoseError {
  std::int64_t t_ns = 0;
  estimator::Pose2 error;                  ///< in the axes of the map [m, m, rad], yaw accumulated
  double heading = 0.0;                    ///< of the reference [rad]
  estimator::PoseCovariance covariance{};  ///< of estimate plus camera's noise, same axes
  std::optional<double> nees;              ///< eᵀP⁻¹e; nothing if P is not positive definite
};

/// Whether the covariances of an estimate apply to its errors after the alignment. Align::first
/// removes the uncertainty of the start: covariances apply only if the start's variances are at
/// most 1 % of the end's. After a fit to all positions they never apply.
[[nodiscard]] bool covariance_is_of_error(std::span<const Pair> pairs, Align align);

/// Both headings are unwrapped. Whole turns between them are removed at the first time and whenever
/// the estimate is reset, as it cannot know the number of turns. Without a covariance `covariance`
/// and `nees` stay empty.
[[nodiscard]] std::vector<PoseError> pose_errors(std::span<const Pair> pairs,
                                                 const estimator::Pose2& alignment,
                                                 bool has_covariance);

/// A PoseError along and across the reference's heading, with its standard deviations.
struct DrivenError {
  double along = 0.0;  ///< ahead of the reference [m]
  double cross = 0.0;  ///< to the left of the reference [m]
  double yaw = 0.0;    ///< [rad]
  double sigma_along = 0.0;
  double sigma_cross = 0.0;
  double sigma_yaw = 0.0;
};
[[nodiscard]] DrivenError driven(const PoseError& error);

/// The 95 % quantile of χ² with three degrees of freedom.
inline constexpr double chi_squared_95_of_3 = 7.814727903251179;

struct Spread {
  double mean = 0.0;
  double rms = 0.0;
  double max = 0.0;
};

/// Computes the spread of magnitudes that are added one by one.
class Gathered {
 public:
  void add(double magnitude) {
    sum_ += magnitude;
    squares_ += magnitude * magnitude;
    max_ = std::max(max_, magnitude);
    ++count_;
  }
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] Spread spread() const {
    const auto n = static_cast<double>(std::max<std::size_t>(count_, 1));
    return {sum_ / n, std::sqrt(squares_ / n), max_};
  }

 private:
  double sum_ = 0.0;
  double squares_ = 0.0;
  double max_ = 0.0;
  std::size_t count_ = 0;
};

/// The horizons, from a tick of 5 ms to a second.
inline constexpr std::array<std::int64_t, 10> horizons_ns{
    5'000'000,   10'000'000,  20'000'000,  35'000'000,  50'000'000,
    100'000'000, 200'000'000, 350'000'000, 500'000'000, 1'000'000'000};

/// The time until the next camera pose: seven ticks of 5 ms.
inline constexpr std::int64_t short_horizon_ns = 35'000'000;

struct HorizonError {
  std::int64_t horizon_ns = 0;
  Spread displacement;      ///< [m]
  Spread yaw;               ///< of the yaw change [rad]
  std::size_t samples = 0;  ///< at least one
};

/// d(t) = R(ψ(t))ᵀ (p(t + T) − p(t)), each trajectory with its own heading; the error is ‖d − d̂‖.
/// Uses all pairs with t + T up to the last pair's time; horizons without any are left out.
[[nodiscard]] std::vector<HorizonError> horizon_errors(const Trajectory& reference,
                                                       const Trajectory& estimate,
                                                       std::span<const Pair> pairs);

}  // namespace odomd::tools
