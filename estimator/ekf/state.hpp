// The state of the full filter: the estimated quantities, and everything else that one instant
// passes to the next. A value: the filter keeps a state per tick of its window.
//
// docs/model.md, "State".
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include <Eigen/Core>

#include "estimator/common/estimate.hpp"
#include "estimator/common/measurement.hpp"
#include "estimator/common/pose.hpp"
#include "estimator/common/tuning.hpp"
#include "estimator/integrity/integrity.hpp"

namespace odomd::estimator::full {

/// The estimated states, SI units. The pose of the centre of gravity is in the map frame, its
/// velocity in the body frame.
namespace at {
enum Index : Eigen::Index {
  x,
  y,
  yaw,
  v_x,
  v_y,
  yaw_rate,
  accel_x,          ///< a_x [m/s²]: specific force along x at the centre of gravity
  front_angle,      ///< ε [rad]: turn of the front wheels beyond the measured steering
  side_force,       ///< e [m/s²]: lateral force beyond the tyre model, per mass
  accel_bias_x,     ///< b_ax [m/s²]
  accel_bias_y,     ///< b_ay [m/s²]
  steering_offset,  ///< δ_0 [rad]: measured = true + offset
  size
};
}  // namespace at

/// Slow errors: scales, biases, slip and gradients that the car's own sensors cannot separate from
/// motion. They are considered, not estimated with the state; `sensitivity` is their effect on it.
/// A camera corrects all of them, a gyro its bias at standstill, an accelerometer its gradient.
namespace slow {
enum Index : Eigen::Index {
  gyro_bias,         ///< b_g [rad/s]
  gyro_scale,        ///< s_g: measured = (1 + s_g) ψ̇ + b_g
  wheel_scale,       ///< s_w: measured = (1 + s_w) v
  wheel_slip,        ///< c_s [s²/m]: a driven wheel is faster by c_s a_x v
  stiffness_scale,   ///< κ: true C = (1 + κ) configured C
  roll_gradient,     ///< ρ_y: measured a_y = (1 + ρ_y) a_y + b_ay
  pitch_gradient,    ///< ρ_x: measured a_x = (1 + ρ_x) a_x + b_ax
  gyro_latency,      ///< τ_g [s]: the gyro is later than configured
  wheel_latency,     ///< τ_w [s]: the wheels are later than configured
  steering_latency,  ///< τ_δ [s]: the steering is later than configured
  wheel_difference,  ///< d: a left wheel is faster by d / 2, a right one slower
  softness,          ///< error of the configured or assumed 1/μ [s²/m], μ the tyres' grip
  size
};
}  // namespace slow

/// Prior knowledge of a slow error.
struct SlowPrior {
  double Tuning::*sigma;
  double Tuning::*walk;  ///< random walk per √s; nullptr: constant
  double lowest;         ///< limits of the model; `highest` also limits sigma
  double highest;
};
inline constexpr std::array<SlowPrior, slow::size> slow_priors = [] {
  constexpr double latency = 0.2;
  constexpr double advanced = 0.5 * latency;  // the most by which samples are advanced
  constexpr double difference = 0.1;
  return std::array<SlowPrior, slow::size>{{
      {&Tuning::gyro_bias, &Tuning::gyro_bias_walk, -1.0, 1.0},
      {&Tuning::gyro_scale, &Tuning::gyro_scale_walk, -0.5, 0.5},
      {&Tuning::wheel_scale, &Tuning::wheel_scale_walk, -0.5, 0.5},
      {&Tuning::wheel_slip, nullptr, -0.5, 0.5},
      {&Tuning::stiffness_scale, &Tuning::stiffness_scale_walk, -0.7, 2.0},
      {&Tuning::roll_gradient, nullptr, -1.0, 1.0},
      {&Tuning::pitch_gradient, nullptr, -1.0, 1.0},
      {&Tuning::latency, nullptr, -latency, latency},
      {&Tuning::latency, nullptr, -latency, latency},
      {&Tuning::latency, nullptr, 0.0, advanced},
      {&Tuning::wheel_difference, nullptr, -difference, difference},
      {&Tuning::softness, nullptr, -0.2, 1.0},
  }};
}();

using Vector = Eigen::Matrix<double, at::size, 1>;
using Matrix = Eigen::Matrix<double, at::size, at::size>;
using SlowVector = Eigen::Matrix<double, slow::size, 1>;
using SlowMatrix = Eigen::Matrix<double, slow::size, slow::size>;
using Sensitivity = Eigen::Matrix<double, at::size, slow::size, Eigen::RowMajor>;

/// s, P_s and B = ∂(x error)/∂(s error). The error of the state is x̃ + B s̃; x̃ and s̃ are
/// independent, with the covariances P and P_s.
struct SlowErrors {
  SlowVector mean = SlowVector::Zero();
  SlowMatrix covariance = SlowMatrix::Zero();
  Sensitivity sensitivity = Sensitivity::Zero();
};

/// The newest sample of a signal that is an input of the model.
struct HeldInput {
  bool seen = false;
  std::int64_t time_ns = 0;
  double value = 0.0;
};

/// Noise of an inertial sensor, from the differences between its samples. On the move vibration
/// makes it several times larger.
struct NoiseLevel {
  struct {
    double mean = 1.0;  ///< variance / stated variance
    int samples = 0;    ///< number of averaged samples
  } moving, still;
  std::array<double, 2> last{};  ///< the two previous samples / stated sigma
  int run = 0;                   ///< number of samples since the wheels last stopped or started
  bool wheels_still = false;
};

/// Readings of the gyro of a standing car.
struct StillGyro {
  std::int64_t since_ns = 0;
  double sum = 0.0;
  int samples = 0;
};

struct Range {
  double lowest = 0.0;
  double highest = 0.0;
};

/// Whether the car stands; see standstill.hpp.
struct Standstill {
  bool standing = false;
  bool wheels_still = false;  ///< since `since_ns`
  std::int64_t since_ns = 0;
  std::array<Range, 2> gyro_ranges;  ///< of gyro readings in the last two stretches [rad/s]
  std::int64_t range_since_ns = 0;
  double still_gyro = 0.0;        ///< mean gyro reading of the standing car [rad/s]
  std::array<StillGyro, 2> gyro;  ///< older, newer; the older has no samples after a departure
  std::int64_t camera_ns = 0;     ///< first camera pose since since_ns; 0: none
  Pose2 first_seen;               ///< the camera pose at camera_ns
  double camera_sigma = 0.0;      ///< sigma of the position of first_seen [m]
  Pose2 off;  ///< newest camera position minus the first; standing: mean minus held position [m]
  double blind = 0.0;  ///< reduction of the wheels' log odds: the car moved while they read 0
  std::array<double, source_count> dead_band{};  ///< a wheel that reads 0 may be this fast [m/s]
};

/// The newest sample of a source, fused or not.
struct Reading {
  int consistent = 0;  ///< consecutive samples that one motion explains, at most 3; 0: none yet
  std::int64_t time_ns = 0;
  double value = 0.0;
  double previous = 0.0;
  double advanced_s = 0.0;             ///< see Sample
  double interval_s = 0.0;             ///< time since the previous sample; 0: none
  double noise_scale = 1.0;            ///< scale of a wheel's relative error
  std::int64_t fused_ns = 0;           ///< newest fused sample; 0: none
  std::int64_t rejected_since_ns = 0;  ///< 0: the newest sample was fused
};

/// A camera pose, and the filter's pose at its time.
struct PosePair {
  std::int64_t capture_ns = 0;
  Pose2 measured;
  Pose2 estimated;
  Pose2 step_error;     ///< measured minus estimated motion since the previous camera pose
  Pose2 seen;           ///< measured motion since the previous camera pose
  double seen_s = 0.0;  ///< duration of `seen` [s]
  bool beyond = false;  ///< this pose is beyond the gate
};

/// A lasting error c of the camera, which P does not contain. The filter follows c: its own error e
/// grows with c, and innovations correlate with the mean m of earlier innovations. The moments of
/// c, e and m are for a c of variance 1.
struct LastingError {
  double seen_s = 0.0;           ///< time over which camera poses have been averaged [s]
  std::array<double, 2> mean{};  ///< m: recent mean of the innovations
  double product = 0.0;          ///< mean of ν m E[ν m]
  double expected = 0.0;         ///< mean of E[ν m]²
  double e_c = 0.0, e_e = 0.0;   ///< E[e c], E[e²]
  double m_c = 0.0, m_e = 0.0;   ///< E[m c], E[m e]
  double variance = 0.0;         ///< of the pose's error due to c [m², rad²]
};

/// Deviation of the filter's speed or yaw rate from the consensus of the sources.
struct Deviation {
  integrity::SourceHistory filter;  ///< the filter's estimate, averaged like a source
  std::int64_t since_ns = 0;        ///< start of the deviation; 0: none
  double sum = 0.0;                 ///< excess over the consensus without wheels or gyro [m, rad]
  bool distrusted = false;          ///< all wheels (speed) or the gyro (yaw rate) are distrusted
};

struct State {
  std::int64_t time_ns = 0;
  Vector mean = Vector::Zero();
  Matrix covariance = Matrix::Zero();  ///< of the state, if the slow errors were known
  SlowErrors slow;
  double drive_noise_scale = 1.0;    ///< scale of a_x's process noise, from the wheels
  double turn_noise_scale = 1.0;     ///< scale of ε's process noise, from the gyro
  double way_noise_scale = 1.0;      ///< scale of the position noise, from the camera
  double turned = 0.0;               ///< yaw added by the steps since turned_since_ns [rad]
  std::int64_t turned_since_ns = 0;  ///< last gyro sample or fused pose; 0: the pose was set
  SlowVector turned_by = SlowVector::Zero();  ///< change of ψ's row of B since then
  double front_wheels = 0.0;                  ///< δ after the steering actuator [rad]
  double side_accel = 0.0;     ///< measured a_y, smoothed over `grip_shown_s` [m/s²]
  double largest_accel = 0.0;  ///< the largest |side_accel| so far [m/s²]
  std::array<NoiseLevel, source_count> noise{};  ///< of the inertial sensors

  bool moving = false;          ///< a wheel speed has started the motion
  Pose2 start;                  ///< pose at the start of the motion
  std::int64_t started_ns = 0;  ///< time of the start; 0: the first speed is confirmed
  bool located = false;         ///< the pose is initialised
  bool unconfirmed = false;     ///< located by a single camera pose
  Standstill standstill;
  HeldInput steering;
  HeldInput accel_x;
  HeldInput accel_y;
  HeldInput direction;

  std::array<Reading, source_count> readings{};

  Integrity integrity;
  Deviation of_speed;
  Deviation of_yaw_rate;
  bool doubtful = false;  ///< a fault may have moved the pose, and no camera has confirmed it since
  int confirming_poses = 0;  ///< consecutive fused camera poses
  /// Corrections by the camera that may be jumps of the map instead [m, m, rad]; their sum,
  /// squared, is added to the published P. A jump there and back cancels.
  Eigen::Vector3d disputed = Eigen::Vector3d::Zero();
  LastingError lasting_way;  ///< of the camera's x and y
  LastingError lasting_turn;
  double camera_noise_scale = 1.0;  ///< variance of camera poses / stated variance
  int camera_steps = 0;             ///< number of steps that taught camera_noise_scale
  PosePair last_camera_pose;        ///< fused or not

  double camera_evidence = 0.0;  ///< log odds that the filter is wrong, from poses beyond the gate
  double camera_test_ratio = 0.0;  ///< of the newest judged camera pose
  std::uint32_t resets = 0;        ///< resets by the camera
  Pose2 last_jump;

  [[nodiscard]] Reading& reading(Source source) noexcept { return readings[index_of(source)]; }
  [[nodiscard]] const Reading& reading(Source source) const noexcept {
    return readings[index_of(source)];
  }
  /// Notes a fused sample.
  void note_fused(Source source, std::int64_t at_ns) noexcept {
    reading(source).fused_ns = at_ns;
    reading(source).rejected_since_ns = 0;
  }
  [[nodiscard]] double& variance(at::Index i) noexcept { return covariance(i, i); }
  [[nodiscard]] double variance(at::Index i) const noexcept { return covariance(i, i); }
  [[nodiscard]] double& variance(slow::Index i) noexcept { return slow.covariance(i, i); }
  [[nodiscard]] double variance(slow::Index i) const noexcept { return slow.covariance(i, i); }
  [[nodiscard]] double sigma(slow::Index i) const noexcept { return std::sqrt(variance(i)); }
  /// A distance along the heading, in map axes.
  [[nodiscard]] Eigen::Vector2d along_heading(double distance) const noexcept {
    return distance * Eigen::Vector2d(std::cos(mean[at::yaw]), std::sin(mean[at::yaw]));
  }
  [[nodiscard]] Pose2 pose() const noexcept { return {mean[at::x], mean[at::y], mean[at::yaw]}; }
  [[nodiscard]] BodyVelocity velocity() const noexcept {
    return {mean[at::v_x], mean[at::v_y], mean[at::yaw_rate]};
  }
};

}  // namespace odomd::estimator::full
