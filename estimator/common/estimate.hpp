// The output of a filter: the pose with its motion and uncertainty at one time.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace odomd::estimator {

/// A pose in the plane: metres, radians counter-clockwise. Yaw is continuous (unwrapped).
struct Pose2 {
  double x = 0.0;
  double y = 0.0;
  double yaw = 0.0;
};

/// The numbers are part of the shared memory's layout: append only.
enum class Mode : std::uint8_t {
  initialising,
  tracking,
  dead_reckoning,
  degraded,
  standstill,
  fault,
  count
};
inline constexpr std::array<std::string_view, static_cast<std::size_t>(Mode::count)> mode_names{
    "initialising", "tracking", "dead_reckoning", "degraded", "standstill", "fault"};

/// Symmetric 3x3 covariance, upper triangle by rows: xx, xy, xyaw, yy, yyaw, yawyaw.
using PoseCovariance = std::array<double, 6>;

/// Calibrations learnt by a filter, in the order of the shared memory: gyro_bias [rad/s],
/// gyro_scale, accel_bias_x, accel_bias_y [m/s²], wheel_scale, steering_offset [rad],
/// stiffness_scale, gyro_latency, wheel_latency, steering_latency [s], grip [m/s²]. A scale of 1 is
/// exact. Latencies are in addition to the configured ones (positive: the sensor is later); grip is
/// the largest lateral acceleration that the tyres allow.
inline constexpr std::size_t calibration_count = 11;
struct Calibration {
  std::array<double, calibration_count> value{0.0, 1.0, 0.0, 0.0, 1.0, 0.0,
                                              1.0, 0.0, 0.0, 0.0, 0.0};
  std::array<double, calibration_count> sigma{};  ///< standard deviations; 0: not estimated
  std::uint64_t valid = 0;                        ///< bit i: the i-th value has been learnt
};

struct Estimate {
  std::int64_t time_ns = 0;  ///< the instant of this estimate
  bool initialised = false;  ///< the pose is valid
  Mode mode = Mode::initialising;
  bool doubtful = false;       ///< a fault may have moved the pose, not yet confirmed by the camera
  bool model_fault = false;    ///< the model has left its domain and stopped (paper: reversing)
  bool bias_unlearnt = false;  ///< the gyro's bias is not known well: stop for 2 s
  /// A learnt scale is far outside its prior: check the configured value.
  bool scale_implausible = false;

  Pose2 map;   ///< centre of gravity in the map frame; jumps when a camera pose re-anchors it
  Pose2 odom;  ///< the same in the odometry frame, which never jumps and starts at the initial pose

  double v_x = 0.0;  ///< velocity of the centre of gravity in the body frame [m/s]
  double v_y = 0.0;
  double yaw_rate = 0.0;  ///< [rad/s]

  double v_x_dot = 0.0;  ///< time derivatives of v_x, v_y, yaw_rate, from the model [m/s², rad/s²]
  double v_y_dot = 0.0;
  double yaw_accel = 0.0;

  double accel_x = 0.0;  ///< newest measured specific force [m/s²]
  double accel_y = 0.0;
  double steering = 0.0;  ///< newest δ [rad]

  PoseCovariance covariance{};           ///< of map (x, y, yaw)
  PoseCovariance velocity_covariance{};  ///< of (v_x, v_y, yaw_rate), same packing

  /// Covariance of (x, y, yaw) with (v_x, v_y, yaw_rate), by rows: x-v_x, x-v_y, ... yaw-yaw_rate.
  std::array<double, 9> cross_covariance{};
  Calibration calibration;

  std::uint32_t reset_count = 0;  ///< re-anchorings of the map pose, including the initialisation
  Pose2 last_jump;  ///< displacement by the last re-anchoring, in map axes; initialising: 0
  std::int64_t camera_ns = 0;      ///< capture time of the last fused camera pose, 0: none yet
  double camera_test_ratio = 0.0;  ///< νᵀS⁻¹ν / gate, of the last camera pose

  std::uint32_t recoveries = 0;  ///< ticks whose state was not finite: the last finite one is kept
};

}  // namespace odomd::estimator
