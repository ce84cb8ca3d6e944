// The state of the full filter: which quantities it estimates, in which order, and all that one
// instant hands to the next. A value: the filter keeps those of the ticks of its window.
//
// docs/model.md, "State".
#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>

#include "estimator/common/estimate.hpp"
#include "estimator/common/measurement.hpp"
#include "estimator/integrity/integrity.hpp"

namespace odomd::estimator::full {

/// What is estimated, SI units. The pose is that of the centre of gravity in the map frame, the
/// velocity that of the same point in the body frame.
namespace at {
enum Index : Eigen::Index {
  x,
  y,
  yaw,
  v_x,
  v_y,
  yaw_rate,
  accel_x,          ///< a_x [m/s²]: specific force along x at the centre of gravity
  front_angle,      ///< ε [rad]: what the front wheels are turned beyond what is known of them
  side_force,       ///< e [m/s²]: what pushes the car sideways beyond its tyres' model, over m
  accel_bias_x,     ///< b_ax [m/s²]
  accel_bias_y,     ///< b_ay [m/s²]
  steering_offset,  ///< δ_0 [rad]: measured = true + offset
  size
};
}  // namespace at

/// Errors that last: scales, a bias, slip, gradients, which the car's own sensors cannot separate
/// from motion. The state is estimated as if these were known; how far it would be off if they were
/// otherwise stands in `sensitivity`. A camera updates them; the gyro its bias at a standstill, the
/// accelerometers what a body's roll and pitch add.
namespace slow {
enum Index : Eigen::Index {
  gyro_bias,        ///< b_g [rad/s]
  gyro_scale,       ///< s_g: measured = (1 + s_g) ψ̇ + b_g
  wheel_scale,      ///< s_w: measured = (1 + s_w) v
  wheel_slip,       ///< c_s [s²/m]: a wheel that drives turns faster by c_s a_x v
  stiffness_scale,  ///< κ: C = (1 + κ) C as configured
  roll_gradient,    ///< ρ_y: measured a_y = (1 + ρ_y) a_y + b_ay
  pitch_gradient,   ///< ρ_x: likewise along x
  size
};
}  // namespace slow

using Vector = Eigen::Matrix<double, at::size, 1>;
using Matrix = Eigen::Matrix<double, at::size, at::size>;
using SlowVector = Eigen::Matrix<double, slow::size, 1>;
using SlowMatrix = Eigen::Matrix<double, slow::size, slow::size>;
using Sensitivity = Eigen::Matrix<double, at::size, slow::size, Eigen::RowMajor>;

/// The errors that last: s, P_s; and B = ∂(x error)/∂(s error), so that the error of the state is
/// x̃ + B s̃, with x̃ of covariance P independent of s̃ of covariance P_s.
struct SlowErrors {
  SlowVector mean = SlowVector::Zero();
  SlowMatrix covariance = SlowMatrix::Zero();
  Sensitivity sensitivity = Sensitivity::Zero();
};

/// The newest sample of a signal that is an input of the model, not a measurement of its state.
struct HeldInput {
  bool seen = false;
  std::int64_t time_ns = 0;
  double value = 0.0;
};

/// How noisy an inertial sensor is, by how its samples scatter from one to the next: vibration
/// makes it several times noisier on the move than at rest. Variances over that of the stated
/// sigma.
struct NoiseLevel {
  double at_rest = 1.0;
  double moving = 1.0;
  int still_samples = 0;  ///< that `at_rest` is the mean of
  int moving_samples = 0;
  std::array<double, 2> last{};  ///< the two samples before, in stated sigmas
  int run = 0;                   ///< how many of them are of the same kind, at rest or moving
  bool wheels_still = false;
};

/// Whether the car stands, judged from wheels and gyro; see standstill.hpp.
struct Standstill {
  bool standing = false;
  bool wheels_still = false;  ///< no wheel turns since since_ns
  std::int64_t since_ns = 0;
  bool gyro_off_bias = false;  ///< the newest reading of the gyro is far from a bias that is known
  std::int64_t gyro_ns = 0;    ///< its newest reading
  double lowest_gyro = 0.0;    ///< readings while it rests [rad/s]
  double highest_gyro = 0.0;
};

/// What a source said last, believed or not.
struct Reading {
  int consistent = 0;  ///< how many in a row, with this one, can be of one motion; 0: never heard
  std::int64_t time_ns = 0;
  double value = 0.0;
  double previous = 0.0;    ///< what it said before that
  double interval_s = 0.0;  ///< since the one before; 0: there was none
};

/// A camera pose, and where the filter was at its time.
struct PosePair {
  std::int64_t capture_ns = 0;
  Pose2 measured;
  Pose2 estimated;
  Pose2 step_error;       ///< the way from the one before as it was seen, less the filter's ...
  bool has_step = false;  ///< ... where there was one before
};

constexpr std::array<double, source_count> filled(double value) noexcept {
  std::array<double, source_count> all{};
  all.fill(value);
  return all;
}

/// By how much the filter's motion has been off what the sources agree on, and since when.
struct Deviation {
  integrity::SourceHistory speed;  ///< the filter's own, averaged as a source's
  integrity::SourceHistory yaw_rate;
  std::int64_t speed_since_ns = 0;  ///< 0: it is not
  std::int64_t yaw_rate_since_ns = 0;
  double distance = 0.0;           ///< [m] driven beyond what all but the wheels say
  double yaw = 0.0;                ///< [rad] turned beyond what all but the gyro say
  bool gyro_distrusted = false;    ///< the gyro is distrusted
  bool wheels_distrusted = false;  ///< all wheels are
};

struct State {
  std::int64_t time_ns = 0;
  Vector mean = Vector::Zero();
  Matrix covariance = Matrix::Zero();  ///< of the state, were the slow errors known
  SlowErrors slow;
  double drive_noise_scale =
      1.0;  ///< variance of what drives a_x, over what is usual; by the wheels
  double turn_noise_scale = 1.0;  ///< likewise of ε, by the gyro
  std::array<double, source_count> wheel_noise_scale =
      filled(1.0);                   ///< of each wheel's relative error
  double way_noise_scale = 1.0;      ///< likewise of the way's error, by the camera
  double turned = 0.0;               ///< by how much the steps have turned the car since ... [rad]
  std::int64_t turned_since_ns = 0;  ///< ... a sample of the gyro; 0: the pose was moved since then
  SlowVector turned_by = SlowVector::Zero();  ///< what the steps have added to ψ's row of B
  double front_wheels = 0.0;                  ///< δ behind the steering's actuator [rad]
  std::array<NoiseLevel, index_of(Source::wheel_front_left)> noise{};  ///< of the inertial sensors

  bool moving = false;   ///< a wheel speed was there: the motion is being followed
  bool located = false;  ///< there is a pose to start from
  Standstill standstill;
  HeldInput steering;
  HeldInput accel_x;
  HeldInput accel_y;
  HeldInput direction;

  std::array<Reading, source_count> readings{};
  std::array<std::int64_t, source_count> fused_ns{};           ///< newest fused sample; 0: none
  std::array<std::int64_t, source_count> rejected_since_ns{};  ///< 0: the newest was fused

  Integrity integrity;       ///< whether the sources tell the truth
  Deviation deviation;       ///< of what they agree on
  bool doubtful = false;     ///< a fault may have moved the pose, and no camera has shown otherwise
  int confirming_poses = 0;  ///< camera poses in a row that have
  bool disputed =
      false;  ///< a camera has moved the pose, and nothing says that it was wrong before
  double camera_noise_scale = 1.0;  ///< variance of the camera's poses over the stated one
  PosePair last_camera_pose;        ///< the camera's newest pose, fused or not

  bool camera_was_distrusted = false;  ///< distrusted since its last fused pose
  int rejected_poses = 0;              ///< of the camera, in a row, of one way with ...
  PosePair first_rejected;             ///< ... the first of them
  double camera_test_ratio = 0.0;      ///< of the newest judged camera pose
  std::uint32_t resets = 0;  ///< times the camera has moved the pose against the filter's will
  Pose2 last_jump;

  [[nodiscard]] Pose2 pose() const noexcept { return {mean[at::x], mean[at::y], mean[at::yaw]}; }
};

}  // namespace odomd::estimator::full
