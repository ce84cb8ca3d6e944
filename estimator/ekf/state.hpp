// The state of the full filter: which quantities it estimates, in which order, and all that one
// instant hands to the next. A value: the filter keeps one for every tick of its window.
#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>

#include "estimator/common/estimate.hpp"
#include "estimator/common/measurement.hpp"

namespace odomd::estimator::full {

/// The states, SI units. The pose is that of the centre of gravity in the map frame, the velocity
/// that of the same point in the body frame.
///
/// The order keeps together what a step of the motion couples: rows 0-5 change, from columns 2-10.
/// Those from `accel_bias_x` on vary slowly, by random walks.
namespace at {
enum Index : Eigen::Index {
  x,
  y,
  yaw,
  v_x,
  v_y,
  yaw_rate,
  front_force,      ///< e [m/s²]: what the front tyres push sideways beyond their model, over m
  yaw_moment,       ///< e_M [rad/s²]: what turns the car beyond the model of the tyres, over J_z
  accel_bias_x,     ///< b_ax [m/s²]
  steering_offset,  ///< δ_0 [rad]: measured = true + offset
  stiffness_scale,  ///< κ: C = (1 + κ) C as configured
  gyro_bias,        ///< b_g [rad/s]
  gyro_scale,       ///< s_g: measured = (1 + s_g) ψ̇ + b_g
  accel_bias_y,     ///< b_ay [m/s²]
  wheel_scale,      ///< s_w: measured = (1 + s_w) v
  size
};
}  // namespace at

using Vector = Eigen::Matrix<double, at::size, 1>;
using Matrix = Eigen::Matrix<double, at::size, at::size>;

/// The newest sample of a signal that is an input of the model, not a measurement of its state.
struct HeldInput {
  bool seen = false;
  std::int64_t time_ns = 0;
  double value = 0.0;
  double sigma = 0.0;       ///< of the sample
  double interval_s = 0.0;  ///< since the one before
};

/// Whether the car stands, judged from wheels and gyro; see standstill.hpp.
struct Rest {
  bool standing = false;
  bool resting = false;  ///< no wheel turns since since_ns
  std::int64_t since_ns = 0;
  bool turned = false;       ///< the newest reading of the gyro is far from a bias that is known
  std::int64_t gyro_ns = 0;  ///< its newest reading
  double lowest_gyro = 0.0;  ///< readings while it rests [rad/s]
  double highest_gyro = 0.0;
};

/// What a source said last, believed or not.
struct Reading {
  int agreeing = 0;  ///< how many in a row, with this one, can be of one motion; 0: never heard
  std::int64_t time_ns = 0;
  double value = 0.0;
  double interval_s = 0.0;  ///< since the one before; 0: there was none
};

/// The samples of a source that were rejected one after the other and do not contradict each other.
struct Rejection {
  int count = 0;  ///< 0: the newest was fused
  std::int64_t since_ns = 0;
  double speed = 0.0;  ///< v_x when it began [m/s]
  bool above = false;  ///< what was measured is more than was predicted
};

/// A camera pose, and where the filter was at its time.
struct Sighting {
  std::int64_t capture_ns = 0;
  Pose2 seen;
  Pose2 believed;
};

/// The camera poses that were rejected one after the other.
struct CameraContender {
  int agreeing = 0;  ///< how many say the same, up to the last
  int steady = 0;    ///< how many a car could have come through, up to the last
  Sighting first_agreeing;
  Sighting first_steady;
  Sighting before_last;  ///< where two are steady
  Sighting last;
};

struct State {
  std::int64_t time_ns = 0;
  Vector mean = Vector::Zero();
  Matrix covariance = Matrix::Zero();

  bool moving = false;   ///< a wheel speed was there: the motion is being followed
  bool located = false;  ///< there is a pose to start from
  Rest rest;
  HeldInput steering;
  HeldInput accel_x;
  HeldInput accel_y;
  HeldInput direction;

  std::array<Reading, source_count> heard{};
  std::array<std::int64_t, source_count> fused_ns{};  ///< newest fused sample; 0: none
  std::array<Rejection, source_count> rejected{};

  CameraContender contender;
  std::int64_t wheels_doubted_until_ns = 0;  ///< for a while after a reset
  double camera_test_ratio = 0.0;            ///< of the newest judged camera pose
  std::uint32_t resets = 0;  ///< times the camera has moved the pose against the filter's will
  Pose2 last_jump;

  [[nodiscard]] Pose2 pose() const noexcept { return {mean[at::x], mean[at::y], mean[at::yaw]}; }
};

}  // namespace odomd::estimator::full
