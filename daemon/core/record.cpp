#include "daemon/core/record.hpp"

#include <algorithm>
#include <cstddef>
#include <tuple>
#include <type_traits>

#include "estimator/common/measurement.hpp"
#include "estimator/common/pose.hpp"

namespace odomd::daemon {
namespace {

using estimator::Estimate;
using estimator::Mode;
using estimator::Source;

// The published numbers are the estimator's.
static_assert(static_cast<int>(Mode::initialising) == ODOM_INITIALISING);
static_assert(static_cast<int>(Mode::tracking) == ODOM_TRACKING);
static_assert(static_cast<int>(Mode::dead_reckoning) == ODOM_DEAD_RECKONING);
static_assert(static_cast<int>(Mode::degraded) == ODOM_DEGRADED);
static_assert(static_cast<int>(Mode::standstill) == ODOM_STANDSTILL);
static_assert(static_cast<int>(Mode::fault) == ODOM_FAULT);
static_assert(static_cast<int>(Source::yaw_rate) == ODOM_SOURCE_YAW_RATE);
static_assert(static_cast<int>(Source::wheel_rear_right) == ODOM_SOURCE_WHEEL_REAR_RIGHT);
static_assert(static_cast<int>(Source::camera) == ODOM_SOURCE_CAMERA);
static_assert(static_cast<int>(Source::count) == ODOM_SOURCE_COUNT);

constexpr std::uint32_t degrading =
    ODOM_COND_NOT_REALTIME | ODOM_COND_RESTARTED | ODOM_COND_BUS_DOWN | ODOM_COND_SIGNAL_TIMEOUT |
    ODOM_COND_PROTECTION | ODOM_COND_FRAMES_LOST | ODOM_COND_CLOCK_STEPPED | ODOM_COND_SUSPENDED |
    ODOM_COND_NON_FINITE | ODOM_COND_INPUT_ENDED | ODOM_COND_SENSOR_FAULT | ODOM_COND_MISWIRED;

// Position of the velocity block in the rest of the 6x6 upper triangle: after the three rows of
// three that couple pose and velocity.
constexpr std::size_t velocity_block = std::tuple_size_v<decltype(Estimate::cross_covariance)>;
static_assert(velocity_block + std::tuple_size_v<estimator::PoseCovariance> ==
              std::extent_v<decltype(odom_details::velocity_covariance)>);

static_assert(std::extent_v<decltype(odom_details::calibration_sigma)> +
                  std::extent_v<decltype(odom_details::further_calibration_sigma)> ==
              estimator::calibration_count);

}  // namespace

std::uint32_t estimator_conditions(const Estimate& estimate) noexcept {
  std::uint32_t bits = 0;
  if (estimate.doubtful) bits |= ODOM_COND_SENSOR_FAULT;
  if (estimate.model_fault) bits |= ODOM_COND_MODEL_FAULT;
  if (estimate.bias_unlearnt) bits |= ODOM_COND_BIAS_UNLEARNT;
  if (estimate.scale_implausible) bits |= ODOM_COND_SCALE_IMPLAUSIBLE;
  return bits;
}

odom_mode published_mode(const Estimate& estimate, std::uint32_t conditions) noexcept {
  if (estimate.model_fault || estimate.mode == Mode::fault) return ODOM_FAULT;
  if (!estimate.initialised) return ODOM_INITIALISING;
  if ((conditions & degrading) != 0) return ODOM_DEGRADED;
  return static_cast<odom_mode>(estimate.mode);
}

void fill_record(const Estimate& estimate, TickRecord& record) noexcept {
  odom_pose& pose = record.pose;
  pose.time_ns = estimate.time_ns;
  pose.x = estimate.map.x;
  pose.y = estimate.map.y;
  pose.yaw = estimate.map.yaw;
  pose.odom_x = estimate.odom.x;
  pose.odom_y = estimate.odom.y;
  pose.odom_yaw = estimate.odom.yaw;
  pose.vx = estimate.v_x;
  pose.vy = estimate.v_y;
  pose.yaw_rate = estimate.yaw_rate;
  pose.vx_dot = estimate.v_x_dot;
  pose.vy_dot = estimate.v_y_dot;
  pose.yaw_accel = estimate.yaw_accel;
  pose.accel_x = estimate.accel_x;
  pose.accel_y = estimate.accel_y;
  pose.steering = estimate.steering;
  std::ranges::copy(estimate.covariance, pose.covariance);
  pose.reset_count = estimate.reset_count;
  pose.jump_x = estimate.last_jump.x;
  pose.jump_y = estimate.last_jump.y;
  pose.jump_yaw = estimate.last_jump.yaw;

  odom_details& details = record.details;
  std::ranges::copy(estimate.cross_covariance, details.velocity_covariance);
  std::ranges::copy(estimate.velocity_covariance, details.velocity_covariance + velocity_block);
  for (std::size_t i = 0; i < calibrations.size(); ++i) {
    details.*calibrations[i].value = estimate.calibration.value[i];
    calibration_sigma(details, i) = estimate.calibration.sigma[i];
  }
  details.calibration_valid = estimate.calibration.valid;
  details.dead_reckoning_since_ns = estimate.camera_ns;

  // T_map_odom = T_map_body ∘ T_odom_body⁻¹
  const estimator::Pose2 correction = estimator::frame_of(estimate.map, estimate.odom);
  details.correction_x = correction.x;
  details.correction_y = correction.y;
  details.correction_yaw = correction.yaw;

  record.initialised = estimate.initialised;
}

Estimate to_estimate(const odom_pose& pose, const odom_details& details) noexcept {
  Estimate estimate;
  estimate.time_ns = pose.time_ns;
  estimate.initialised = pose.mode != ODOM_INITIALISING;
  estimate.model_fault = pose.mode == ODOM_FAULT;
  estimate.map = {pose.x, pose.y, pose.yaw};
  estimate.odom = {pose.odom_x, pose.odom_y, pose.odom_yaw};
  estimate.v_x = pose.vx;
  estimate.v_y = pose.vy;
  estimate.yaw_rate = pose.yaw_rate;
  estimate.v_x_dot = pose.vx_dot;
  estimate.v_y_dot = pose.vy_dot;
  estimate.yaw_accel = pose.yaw_accel;
  estimate.accel_x = pose.accel_x;
  estimate.accel_y = pose.accel_y;
  estimate.steering = pose.steering;
  std::ranges::copy(pose.covariance, estimate.covariance.begin());
  std::copy_n(details.velocity_covariance, estimate.cross_covariance.size(),
              estimate.cross_covariance.begin());
  std::copy_n(details.velocity_covariance + velocity_block, estimate.velocity_covariance.size(),
              estimate.velocity_covariance.begin());
  for (std::size_t i = 0; i < calibrations.size(); ++i) {
    estimate.calibration.value[i] = details.*calibrations[i].value;
    estimate.calibration.sigma[i] = calibration_sigma(details, i);
  }
  estimate.calibration.valid = details.calibration_valid;
  estimate.reset_count = pose.reset_count;
  estimate.last_jump = {pose.jump_x, pose.jump_y, pose.jump_yaw};
  estimate.camera_ns = details.dead_reckoning_since_ns;
  return estimate;
}

}  // namespace odomd::daemon
