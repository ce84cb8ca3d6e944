// Any sequence of frames, camera messages and ticks through the pipeline: no tick publishes a
// number that is none, a variance below zero, or an older time.
//
// The input is a model (one byte) and then commands: a frame (0-5: which signal; its stamp's lead
// over the clock in units of 0.1 ms, signed; eight bytes of payload), a camera message (6: as the
// wire carries it), a tick (all else).
#include "daemon/pipeline.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "daemon/camera_wire.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace {

using odomd::daemon::Pipeline;
using odomd::estimator::Source;
using odomd::fuzz::require;

constexpr std::int64_t period_ns = 5'000'000;
constexpr std::int64_t start_ns = 1'000'000'000'000;

/// Every signal a bare 64-bit float, so that any number at all can be sent.
constexpr std::array signals{Source::yaw_rate,         Source::accel_x,  Source::wheel_rear_left,
                             Source::wheel_rear_right, Source::steering, Source::direction};

odomd::can::Database database() {
  std::string text;
  for (std::size_t i = 0; i < signals.size(); ++i) {
    const std::string id = std::to_string(256 + i);
    text += "BO_ " + id + " M" + std::to_string(i) + ": 8 X\n SG_ S : 0|64@1- (1,0) [0|0] \"\" X\n";
  }
  for (std::size_t i = 0; i < signals.size(); ++i)
    text += "SIG_VALTYPE_ " + std::to_string(256 + i) + " S : 2;\n";
  return odomd::can::parse_dbc(text, "fuzz.dbc");
}

odomd::daemon::Config config(odomd::estimator::Model model) {
  odomd::daemon::Config config;
  config.model = model;
  for (std::size_t i = 0; i < signals.size(); ++i) {
    const auto channel = static_cast<std::uint16_t>(signals[i]);
    odomd::can::SignalBinding binding;
    binding.channel = channel;
    binding.role = "role";
    binding.message = "M" + std::to_string(i);
    binding.signals = {"S"};
    if (signals[i] == Source::direction) {
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

class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size) : rest_(data, size) {}
  [[nodiscard]] bool empty() const { return rest_.empty(); }

  /// Zeros where the input has ended.
  template <typename Value>
  Value take() {
    Value value{};
    const std::size_t size = std::min(sizeof value, rest_.size());
    std::memcpy(&value, rest_.data(), size);
    rest_ = rest_.subspan(size);
    return value;
  }

 private:
  std::span<const std::uint8_t> rest_;
};

void check(const odomd::daemon::TickRecord& record, std::int64_t tick_ns) {
  const odom_pose& pose = record.pose;
  for (const double value :
       {pose.x, pose.y, pose.yaw, pose.odom_x, pose.odom_y, pose.odom_yaw, pose.vx, pose.vy,
        pose.yaw_rate, pose.vx_dot, pose.vy_dot, pose.yaw_accel, pose.accel_x, pose.accel_y,
        pose.steering, pose.jump_x, pose.jump_y, pose.jump_yaw})
    require(std::isfinite(value), "the pose is finite");
  for (const double value : pose.covariance) require(std::isfinite(value), "so is its covariance");
  for (const double value : record.details.velocity_covariance)
    require(std::isfinite(value), "so is that of the velocities");
  require(pose.covariance[0] >= 0.0 && pose.covariance[3] >= 0.0 && pose.covariance[5] >= 0.0,
          "no variance is negative");
  require(pose.time_ns == tick_ns, "the pose is of its tick");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::vector<odomd::can::Database> databases{database()};
  static const std::vector<std::string> buses{"can0"};
  Input input(data, size);
  const auto model = static_cast<odomd::estimator::Model>(input.take<std::uint8_t>() %
                                                          odomd::estimator::model_names.size());
  const auto pipeline = std::make_unique<Pipeline>(config(model), databases, buses, true);
  odomd::can::WallClock wall;
  wall.update({start_ns, 1'760'000'000'000'000'000 + start_ns, start_ns, start_ns});
  const odomd::daemon::MessageClocks clocks{wall, start_ns / 2};

  std::uint64_t number = 1;
  std::int64_t now = start_ns;
  while (!input.empty()) {
    const auto command = input.take<std::uint8_t>();
    if (command < signals.size()) {
      odomd::can::Frame frame;
      frame.id = 256U + command;
      frame.length = 8;
      frame.time_ns = now + std::int64_t{input.take<std::int16_t>()} * 100'000;
      const auto payload = input.take<std::array<std::uint8_t, 8>>();
      std::copy(payload.begin(), payload.end(), frame.data.begin());
      pipeline->take(frame, now);
    } else if (command == signals.size()) {
      const auto bytes = input.take<std::array<std::byte, sizeof(odom_camera_message)>>();
      const auto message =
          odomd::daemon::read_camera_message(bytes, sizeof(odom_camera_message), clocks, now);
      if (message.cause == odomd::daemon::MalformedCause::none)
        pipeline->take(message.pose);
      else
        pipeline->take_malformed_camera_message();
    } else {
      now += period_ns;
      check(pipeline->tick(number++, now), now);
    }
  }
  return 0;
}
