// Shared by the fuzzers of the pipeline: a car whose signals are all 64-bit floats, which can carry
// any number, and checks of every pose.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/wall_clock.hpp"
#include "daemon/core/pipeline.hpp"
#include "tests/can_protocol/decode/one_binding.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace odomd::fuzz {

inline constexpr std::int64_t period_ns = 5'000'000;
inline constexpr std::int64_t start_ns = 1'000'000'000'000;

inline constexpr std::array signals{
    estimator::Source::yaw_rate,        estimator::Source::accel_x,
    estimator::Source::wheel_rear_left, estimator::Source::wheel_rear_right,
    estimator::Source::steering,        estimator::Source::direction};

inline can::Database database() {
  std::string text;
  for (std::size_t i = 0; i < signals.size(); ++i) {
    const std::string id = std::to_string(256 + i);
    text += "BO_ " + id + " M" + std::to_string(i) + ": 8 X\n SG_ S : 0|64@1- (1,0) [0|0] \"\" X\n";
  }
  for (std::size_t i = 0; i < signals.size(); ++i)
    text += "SIG_VALTYPE_ " + std::to_string(256 + i) + " S : 2;\n";
  return can::parse_dbc(text, "fuzz.dbc");
}

inline daemon::Config config(estimator::Model model) {
  daemon::Config config;
  config.model = model;
  for (std::size_t i = 0; i < signals.size(); ++i) {
    const auto channel = static_cast<std::uint16_t>(signals[i]);
    can::SignalBinding binding = can::binding_of("M" + std::to_string(i), "S", channel);
    if (signals[i] == estimator::Source::direction) {
      binding.forward = 1.0;
      binding.reverse = 2.0;
    }
    config.can.bindings.push_back(binding);
    config.can.signals[channel] = {.configured = true, .sigma = 0.03, .timeout_ns = 30'000'000};
  }
  config.camera.configured = true;
  config.camera.lever_arm = {0.1, 0.02, 0.3};
  return config;
}

/// A pipeline of the car, on one bus.
inline std::unique_ptr<daemon::Pipeline> pipeline_of(const daemon::Config& config,
                                                     bool camera_expected) {
  static const std::vector<can::Database> databases{database()};
  static const std::vector<std::string> buses{"can0"};
  return std::make_unique<daemon::Pipeline>(config, databases, buses, camera_expected);
}

/// A clock whose real time is in the year 2025.
inline WallClock wall_clock() {
  WallClock wall;
  wall.update({start_ns, 1'760'000'000'000'000'000 + start_ns, start_ns, start_ns});
  return wall;
}

inline void check(const daemon::TickRecord& record, std::int64_t tick_ns) {
  const odom_pose& pose = record.pose;
  for (const double value :
       {pose.x, pose.y, pose.yaw, pose.odom_x, pose.odom_y, pose.odom_yaw, pose.vx, pose.vy,
        pose.yaw_rate, pose.vx_dot, pose.vy_dot, pose.yaw_accel, pose.accel_x, pose.accel_y,
        pose.steering, pose.jump_x, pose.jump_y, pose.jump_yaw})
    require(std::isfinite(value), "the pose is finite");
  for (const double value : pose.covariance)
    require(std::isfinite(value), "its covariance is finite");
  for (const double value : record.details.velocity_covariance)
    require(std::isfinite(value), "the covariance of the velocities is finite");
  require(pose.covariance[0] >= 0.0 && pose.covariance[3] >= 0.0 && pose.covariance[5] >= 0.0,
          "no variance is negative");
  require(pose.time_ns == tick_ns, "the pose is of its tick");
}

}  // namespace odomd::fuzz
