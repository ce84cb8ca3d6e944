// A car with a few signals, its frames over three seconds, and how a receiver decodes them.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "can_protocol/decode/decoder.hpp"
#include "can_protocol/decode/message_encoder.hpp"
#include "daemon/core/config.hpp"
#include "daemon/core/pipeline.hpp"
#include "tools/fault/injector.hpp"
#include "tools/sim/car_bus.hpp"

namespace odomd::fault {

using estimator::Source;

inline constexpr std::int64_t second_ns = 1'000'000'000;
inline constexpr std::int64_t start_ns = 1000 * second_ns;
inline constexpr std::int64_t cycle_ns = 10'000'000;

/// A signal as in odomd's own database, and the value of its least significant bit.
struct Signal {
  Source source;
  const char* message;
  const char* name;
  double step;
};
inline constexpr std::array small_car_signals{
    Signal{Source::yaw_rate, "IMU", "YawRate", 2e-4},
    Signal{Source::accel_x, "IMU", "AccX", 2.5e-3},
    Signal{Source::accel_y, "IMU", "AccY", 2.5e-3},
    Signal{Source::wheel_front_left, "WHEELS_FRONT", "WheelFrontLeft", 1e-5},
    Signal{Source::wheel_front_right, "WHEELS_FRONT", "WheelFrontRight", 1e-5},
    Signal{Source::wheel_rear_left, "WHEELS_REAR", "WheelRearLeft", 1e-5},
    Signal{Source::wheel_rear_right, "WHEELS_REAR", "WheelRearRight", 1e-5},
    Signal{Source::steering, "STEERING", "SteeringAngle", 1e-6},
};

/// The healthy reading of a sensor, different for each.
inline double healthy(Source source, double t) {
  const auto number = static_cast<double>(estimator::index_of(source));
  return 1.0 + 0.1 * number + 0.3 * std::sin(2.0 * t + number);
}

inline daemon::Config small_car() {
  daemon::Config config;
  config.file = "car.toml";
  for (const Signal& signal : small_car_signals) {
    can::SignalBinding binding;
    binding.channel = static_cast<std::uint16_t>(signal.source);
    binding.role = estimator::source_names[estimator::index_of(signal.source)];
    binding.message = signal.message;
    binding.signals = {signal.name};
    config.can.bindings.push_back(binding);
    config.can.signals[estimator::index_of(signal.source)] = {true, 0.01, 0};
  }
  for (const can::Message& message : sim::bus_database().messages)
    config.can.protections.push_back(sim::bus_protection(message));
  return config;
}

/// Three seconds of all messages, each every 10 ms, a millisecond apart.
inline std::vector<can::Frame> healthy_frames() {
  std::vector<can::MessageEncoder> encoders;
  for (const can::Message& message : sim::bus_database().messages)
    encoders.emplace_back(message, sim::bus_protection(message));
  std::vector<can::Frame> frames;
  for (std::int64_t at_ns = 0; at_ns < 3 * second_ns; at_ns += cycle_ns)
    for (std::size_t i = 0; i < encoders.size(); ++i) {
      for (const Signal& signal : small_car_signals)
        if (encoders[i].message().name == signal.message)
          encoders[i].set(signal.name, healthy(signal.source, static_cast<double>(at_ns) * 1e-9));
      frames.push_back(
          encoders[i].frame(start_ns + at_ns + static_cast<std::int64_t>(i) * 1'000'000));
    }
  return frames;
}

inline std::vector<can::Frame> with(const daemon::Config& config, std::span<const Fault> faults,
                                    std::span<const can::Frame> frames) {
  const std::vector<can::Database> databases{sim::bus_database()};
  const std::vector<std::string> buses{"can0"};
  Injector injector(config, databases, buses, faults);
  std::vector<can::Frame> out;
  for (const can::Frame& frame : frames) injector.take(frame, out);
  injector.release(end_of_time, out);
  return out;
}

/// The healthy car's frames with faults.
inline std::vector<can::Frame> with(const std::vector<Fault>& faults) {
  return with(small_car(), faults, healthy_frames());
}

struct Value {
  double t = 0.0;  ///< time of the frame [s]
  double value = 0.0;
};

struct Decoded {
  std::map<Source, std::vector<Value>> values;
  std::map<can::FrameVerdict, int> verdicts;
};

/// Decodes frames as the daemon does, and checks their protection.
inline Decoded decoded(std::span<const can::Frame> frames) {
  const daemon::Config config = small_car();
  const std::vector<can::Database> databases{sim::bus_database()};
  const std::vector<std::string> buses{"can0"};
  can::Decoder decoder(databases, config.can.bindings, config.can.protections, buses);
  std::array<can::Sample, can::max_samples_per_frame> samples{};
  Decoded result;
  for (const can::Frame& frame : frames) {
    const can::DecodeResult one = decoder.decode(frame, samples);
    ++result.verdicts[one.verdict];
    for (std::size_t i = 0; i < one.count; ++i)
      result.values[static_cast<Source>(samples[i].channel)].push_back(
          {static_cast<double>(samples[i].time_ns - start_ns) * 1e-9, samples[i].value});
  }
  return result;
}

/// A fault from 1 s to 2 s after the first frame.
inline Fault in_the_middle(std::string_view kind) {
  Fault fault = fault_of(parse_kind(kind));
  fault.begin_s = 1.0;
  fault.duration_s = 1.0;
  return fault;
}

inline bool is_in_the_middle(double t) {
  return t > 1.0 - 1e-9 && t < 2.0 - 1e-9;
}

}  // namespace odomd::fault
