// The control units and the bus between them: samples at the rate of inexact clocks, as protected
// frames of odomd.dbc, one at a time on a wire of 500 kbit/s.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "can_protocol/decode/message_encoder.hpp"
#include "tools/sim/sensors/sensors.hpp"

namespace odomd::sim {

/// The text of odomd.dbc: unchanged, with the cycle times of a car, or with given cycle times.
[[nodiscard]] std::string_view bus_database_text();
[[nodiscard]] std::string bus_database_text(const ParameterSet& truth);
/// A cycle time of 0 ns means none.
[[nodiscard]] std::string bus_database_text(
    const std::function<std::int64_t(std::string_view message)>& cycle_ns);

/// Cycle time of a message [ns].
[[nodiscard]] std::int64_t cycle_ns(const ParameterSet& truth, std::string_view message);

/// The messages of odomd.dbc, each protected by Profile 1 with its identifier as the data id.
[[nodiscard]] const can::Database& bus_database();
[[nodiscard]] can::E2eBinding bus_protection(const can::Message& message);
/// The table [can.e2e] for all messages.
[[nodiscard]] std::string bus_protection_text();

/// The signal of each role of a configuration on this bus.
struct BusRole {
  std::string_view role, message, signal, unit;
};
[[nodiscard]] std::span<const BusRole> bus_roles();

class CarBus {
 public:
  CarBus(const ParameterSet& truth, double configured_wheel_radius, std::uint64_t seed);

  /// Takes the samples that are due after `from_ns` and up to `to_ns`; the car is given at both
  /// times, and interpolated between them. Appends the frames with increasing stamps.
  void advance(std::int64_t from_ns, const PlantOutput& from, std::int64_t to_ns,
               const PlantOutput& to, std::vector<can::Frame>& frames);

 private:
  /// The sender of a message; units are in the order of the database.
  struct Unit {
    can::MessageEncoder encoder;
    RandomStream jitter;
    std::int64_t phase_ns = 0;
    std::int64_t cycle_ns = 0;
    std::int64_t count = 0;    // samples so far
    std::int64_t due_ns = 0;   // next sample
    std::int64_t last_ns = 0;  // previous sample
  };

  void schedule(Unit& unit) const;
  void sample(Unit& unit);
  [[nodiscard]] PlantOutput car_before(std::int64_t time_ns, Parameter latency) const;
  can::Frame transmit(Unit& unit);

  ParameterSet truth_;
  std::vector<Unit> units_;
  Imu imu_;
  SteeringSensor steering_;
  std::array<WheelEncoder, wheel_count> wheels_;
  PastOutputs past_;
  RandomStream stamp_noise_;
  std::int64_t bus_free_ns_ = 0;
  std::int64_t last_stamp_ns_ = 0;
};

}  // namespace odomd::sim
