#include "daemon/core/record.hpp"

#include <algorithm>
#include <cstddef>
#include <tuple>
#include <type_traits>
#include <utility>

#include "estimator/common/measurement.hpp"
#include "estimator/common/pose.hpp"

namespace odomd::daemon {
namespace {

using estimator::Estimate;
using estimator::Mode;
using estimator::Source;

// The published modes and sources have the numbers of the estimator's enumerators.
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

std::tuple<double, double, double> parts_of(const estimator::Pose2& pose) noexcept {
  return {pose.x, pose.y, pose.yaw};
}

/// The numbers that both odom_pose and Estimate have.
constexpr std::pair<double odom_pose::*, double Estimate::*> motion[]{
    {&odom_pose::vx, &Estimate::v_x},
    {&odom_pose::vy, &Estimate::v_y},
    {&odom_pose::yaw_rate, &Estimate::yaw_rate},
    {&odom_pose::vx_dot, &Estimate::v_x_dot},
    {&odom_pose::vy_dot, &Estimate::v_y_dot},
    {&odom_pose::yaw_accel, &Estimate::yaw_accel},
    {&odom_pose::accel_x, &Estimate::accel_x},
    {&odom_pose::accel_y, &Estimate::accel_y},
    {&odom_pose::steering, &Estimate::steering},
};

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
  std::tie(pose.x, pose.y, pose.yaw) = parts_of(estimate.map);
  std::tie(pose.odom_x, pose.odom_y, pose.odom_yaw) = parts_of(estimate.odom);
  for (const auto& [published, estimated] : motion) pose.*published = estimate.*estimated;
  std::ranges::copy(estimate.covariance, pose.covariance);
  pose.reset_count = estimate.reset_count;
  std::tie(pose.jump_x, pose.jump_y, pose.jump_yaw) = parts_of(estimate.last_jump);

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
  std::tie(details.correction_x, details.correction_y, details.correction_yaw) =
      parts_of(estimator::frame_of(estimate.map, estimate.odom));

  record.initialised = estimate.initialised;
}

Estimate to_estimate(const odom_pose& pose, const odom_details& details) noexcept {
  Estimate estimate;
  estimate.time_ns = pose.time_ns;
  estimate.initialised = pose.mode != ODOM_INITIALISING;
  estimate.model_fault = pose.mode == ODOM_FAULT;
  estimate.map = {pose.x, pose.y, pose.yaw};
  estimate.odom = {pose.odom_x, pose.odom_y, pose.odom_yaw};
  for (const auto& [published, estimated] : motion) estimate.*estimated = pose.*published;
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
