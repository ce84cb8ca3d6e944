// A car with a gyro and a wheel on a bus, and the pipeline that receives its frames.
#pragma once

#include <bit>
#include <memory>

#include "daemon/core/pipeline.hpp"
#include "tests/gtest.hpp"

namespace odomd::daemon::pipeline_test {

using estimator::Source;
using estimator::Verdict;

inline constexpr std::int64_t ms = 1'000'000;
inline constexpr std::int64_t start = 1'000'000 * ms;
inline constexpr std::size_t gyro = 0;
inline constexpr auto wheel = static_cast<std::size_t>(Source::wheel_rear);
inline constexpr auto camera = static_cast<std::size_t>(Source::camera);

inline constexpr std::string_view bus = R"(VERSION ""
BO_ 256 IMU: 4 Car
 SG_ YawRate : 0|16@1- (0.001,0) [0|0] "rad/s" X
 SG_ Counter : 16|4@1+ (1,0) [0|15] "" X

BO_ 257 WHEEL: 2 Car
 SG_ Speed : 0|16@1- (0.001,0) [0|0] "m/s" X

BO_ 258 FLOAT: 4 Car
 SG_ Speed : 0|32@1- (1,0) [0|0] "m/s" X

SIG_VALTYPE_ 258 Speed : 1;
)";

inline Config two_signals(estimator::Model model = estimator::Model::kinematic) {
  Config config;
  config.model = model;
  config.can.bindings = {
      {.channel = gyro,
       .role = "yaw_rate",
       .message = "IMU",
       .signals = {"YawRate"},
       .unit = can::Unit::rad_per_s},
      {.channel = wheel,
       .role = "wheel_rear",
       .message = "WHEEL",
       .signals = {"Speed"},
       .unit = can::Unit::m_per_s},
  };
  config.can.protections = {
      {.message = "IMU", .profile = can::E2eProfile::counter, .counter_signal = "Counter"}};
  config.can.signals[gyro] = {.configured = true, .sigma = 0.03, .timeout_ns = 30 * ms};
  config.can.signals[wheel] = {.configured = true, .sigma = 0.02, .timeout_ns = 30 * ms};
  config.initial_pose = estimator::Pose2{};
  return config;
}

/// A car's pipeline. Times are in ms after the start; frames arrive at their time.
struct Car {
  explicit Car(const Config& config = two_signals(), bool camera_expected = false)
      : pipeline(std::make_unique<Pipeline>(
            config, std::vector<can::Database>{can::parse_dbc(bus, "test.dbc")},
            std::vector<std::string>{"can0", "can1"}, camera_expected)) {}

  void wheel_reads(std::int64_t at_ms, std::int16_t value) const {
    take(257, start + at_ms * ms, value, start + at_ms * ms);
  }
  void gyro_reads(std::int64_t at_ms, std::int16_t value, std::int64_t counter) const {
    take(256, start + at_ms * ms, value, start + at_ms * ms, counter);
  }
  void take(std::uint32_t id, std::int64_t time_ns, std::int16_t value, std::int64_t now_ns,
            std::int64_t counter = 0) const {
    can::Frame frame{.time_ns = time_ns, .id = id, .length = 4};
    const auto raw = std::bit_cast<std::uint16_t>(value);
    frame.data[0] = static_cast<std::uint8_t>(raw & 0xFFU);
    frame.data[1] = static_cast<std::uint8_t>(raw >> 8U);
    frame.data[2] = static_cast<std::uint8_t>(counter % 16);
    pipeline->take(frame, now_ns);
  }
  [[nodiscard]] const TickRecord& tick(std::int64_t at_ms) const {
    return pipeline->tick(static_cast<std::uint64_t>(at_ms / 5), start + at_ms * ms);
  }
  /// Adds a camera pose and runs a tick; returns whether the camera counts as rejected.
  [[nodiscard]] bool rejects(const estimator::CameraPose& pose, std::int64_t at_ms) const {
    pipeline->take(pose);
    return (tick(at_ms).pose.conditions & ODOM_COND_CAMERA_REJECTED) != 0;
  }
  [[nodiscard]] std::uint64_t count(std::size_t source, Verdict verdict) const {
    return pipeline->statistics().sources[source].verdicts[static_cast<std::size_t>(verdict)].get();
  }
  [[nodiscard]] estimator::SourceFlag flag(std::size_t source) const {
    return static_cast<estimator::SourceFlag>(pipeline->statistics().sources[source].flag.get());
  }
  std::unique_ptr<Pipeline> pipeline;
};

inline estimator::CameraPose seen(double x, std::int64_t capture_ms, std::int64_t arrival_ms,
                                  double sigma = 0.01) {
  return {.capture_ns = start + capture_ms * ms,
          .arrival_ns = start + arrival_ms * ms,
          .x = x,
          .sigma_x = sigma,
          .sigma_y = sigma,
          .sigma_yaw = sigma};
}

}  // namespace odomd::daemon::pipeline_test
