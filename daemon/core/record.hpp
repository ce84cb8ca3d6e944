// Converts an estimate to the published record and back: the only place that knows both the
// estimator's types and those of the shared memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <type_traits>

#include <odom/types.h>

#include "estimator/common/estimate.hpp"

namespace odomd::daemon {

/// The results that a tick publishes.
struct TickRecord {
  odom_pose pose{};
  odom_details details{};
  bool initialised = false;  ///< the pose is valid: replay writes rows from here on
};

/// The names of the calibrations for users, in the order of estimator::Calibration.
struct PublishedCalibration {
  std::string_view name;
  double odom_details::*value;
};
inline constexpr std::array<PublishedCalibration, estimator::calibration_count> calibrations{{
    {"gyro_bias", &odom_details::gyro_bias},
    {"gyro_scale", &odom_details::gyro_scale},
    {"accel_bias_x", &odom_details::accel_bias_x},
    {"accel_bias_y", &odom_details::accel_bias_y},
    {"wheel_scale", &odom_details::wheel_scale},
    {"steering_offset", &odom_details::steering_offset},
    {"stiffness_scale", &odom_details::stiffness_scale},
    {"gyro_latency", &odom_details::gyro_latency},
    {"wheel_latency", &odom_details::wheel_latency},
    {"steering_latency", &odom_details::steering_latency},
    {"grip", &odom_details::grip},
}};

/// The standard deviation of calibration `i` of odom_details; 0: not estimated.
[[nodiscard]] constexpr auto& calibration_sigma(auto& details, std::size_t i) noexcept {
  constexpr std::size_t first = std::extent_v<decltype(odom_details::calibration_sigma)>;
  return i < first ? details.calibration_sigma[i] : details.further_calibration_sigma[i - first];
}

/// The ODOM_COND_ bits that follow from the estimate alone.
[[nodiscard]] std::uint32_t estimator_conditions(const estimator::Estimate& estimate) noexcept;

/// The mode to publish, by precedence: fault, initialising, degraded, standstill, dead reckoning,
/// tracking. `conditions` are ODOM_COND_ bits; some of them make the mode degraded.
[[nodiscard]] odom_mode published_mode(const estimator::Estimate& estimate,
                                       std::uint32_t conditions) noexcept;

/// Fills in everything that the estimate knows. The pipeline sets tick, conditions, mode, health,
/// ages and counts.
void fill_record(const estimator::Estimate& estimate, TickRecord& record) noexcept;

/// The state of a published pose, from which a successor can resume.
[[nodiscard]] estimator::Estimate to_estimate(const odom_pose& pose,
                                              const odom_details& details) noexcept;

/// Resumes from a pose that is younger than this.
inline constexpr std::int64_t inheritance_ns = 2'000'000'000;

/// The age of the pose; empty when it is too old, in the future, or not usable.
[[nodiscard]] constexpr std::optional<std::int64_t> resumable_pose_age(
    const odom_pose& pose, std::int64_t now_ns) noexcept {
  if (pose.mode == ODOM_INITIALISING || pose.mode == ODOM_FAULT) return std::nullopt;
  // Compared before the subtraction, because a file may contain any number.
  if (pose.time_ns > now_ns || pose.time_ns <= now_ns - inheritance_ns) return std::nullopt;
  return now_ns - pose.time_ns;
}

}  // namespace odomd::daemon
