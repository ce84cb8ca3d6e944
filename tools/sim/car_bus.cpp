#include "tools/sim/car_bus.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace odomd::sim {
namespace {

using enum Parameter;

// 8 bytes with an identifier of 11 bits: 111 bits and about 15 stuff bits, at 500 kbit/s.
constexpr std::int64_t frame_ns = 252'000;

constexpr std::array roles{
    BusRole{"yaw_rate", "IMU", "YawRate", "rad/s"},
    BusRole{"accel_x", "IMU", "AccX", "m/s2"},
    BusRole{"accel_y", "IMU", "AccY", "m/s2"},
    BusRole{"wheel_front_left", "WHEELS_FRONT", "WheelFrontLeft", "m/s"},
    BusRole{"wheel_front_right", "WHEELS_FRONT", "WheelFrontRight", "m/s"},
    BusRole{"wheel_rear_left", "WHEELS_REAR", "WheelRearLeft", "m/s"},
    BusRole{"wheel_rear_right", "WHEELS_REAR", "WheelRearRight", "m/s"},
    BusRole{"steering", "STEERING", "SteeringAngle", "rad"},
};

}  // namespace

// Rounded to milliseconds, as stated in the database.
std::int64_t cycle_ns(const ParameterSet& truth, std::string_view message) {
  const Parameter cycle = message == "IMU"        ? imu_cycle
                          : message == "STEERING" ? steering_cycle
                                                  : wheel_cycle;
  return 1'000'000 * std::llround(1000.0 * truth[cycle]);
}

std::string bus_database_text(
    const std::function<std::int64_t(std::string_view message)>& cycle_ns) {
  std::string text(bus_database_text());
  for (const can::Message& message : bus_database().messages) {
    const std::string key = "BA_ \"GenMsgCycleTime\" BO_ " + std::to_string(message.id) + " ";
    const std::size_t begin = text.find(key) + key.size();
    const std::size_t end = text.find(';', begin);
    text.replace(begin, end - begin, std::to_string(cycle_ns(message.name) / 1'000'000));
  }
  return text;
}

std::string bus_database_text(const ParameterSet& truth) {
  return bus_database_text([&](std::string_view message) { return cycle_ns(truth, message); });
}

const can::Database& bus_database() {
  static const can::Database database = can::parse_dbc(bus_database_text(), "odomd.dbc");
  return database;
}

can::E2eBinding bus_protection(const can::Message& message) {
  can::E2eBinding binding;
  binding.message = message.name;
  binding.profile = can::E2eProfile::p01;
  binding.data_id = static_cast<std::uint16_t>(message.id);
  binding.data_id_mode = can::DataIdMode::both;
  binding.crc_signal = message.name + "_CRC";
  binding.counter_signal = message.name + "_Counter";
  return binding;
}

std::string bus_protection_text() {
  std::string text = "[can.e2e]\n";
  for (const can::Message& message : bus_database().messages) {
    const can::E2eBinding binding = bus_protection(message);
    text += message.name + " = { profile = \"P01\", data_id = " + std::to_string(binding.data_id) +
            ", data_id_mode = \"BOTH\", crc = \"" + binding.crc_signal + "\", counter = \"" +
            binding.counter_signal + "\" }\n";
  }
  return text;
}

std::span<const BusRole> bus_roles() {
  return roles;
}

CarBus::CarBus(const ParameterSet& truth, double configured_wheel_radius, std::uint64_t seed)
    : truth_(truth),
      imu_(truth, seed),
      steering_(truth, seed),
      wheels_{WheelEncoder(truth, front_left, configured_wheel_radius, seed),
              WheelEncoder(truth, front_right, configured_wheel_radius, seed),
              WheelEncoder(truth, rear_left, configured_wheel_radius, seed),
              WheelEncoder(truth, rear_right, configured_wheel_radius, seed)},
      past_(nanoseconds(std::max({truth[gyro_latency], truth[accel_latency], truth[wheel_latency],
                                  truth[steering_latency]}))),
      stamp_noise_(seed, "time stamps") {
  for (const can::Message& message : bus_database().messages) {
    Unit unit{.encoder = can::MessageEncoder(message, bus_protection(message)),
              .jitter = RandomStream(seed, "clock of " + message.name),
              .cycle_ns = cycle_ns(truth, message.name)};
    unit.phase_ns = nanoseconds(unit.jitter.uniform() * seconds(unit.cycle_ns));
    schedule(unit);
    units_.push_back(std::move(unit));
  }
}

// Jitter does not accumulate: each sample deviates from its own time on the grid, by less than a
// quarter of a cycle.
void CarBus::schedule(Unit& unit) const {
  const double stray = truth_[cycle_jitter] * unit.jitter.normal();
  const double most = 0.25 * seconds(unit.cycle_ns);
  const double grid =
      static_cast<double>(unit.count) * seconds(unit.cycle_ns) * truth_[clock_error];
  unit.last_ns = unit.count > 0 ? unit.due_ns : 0;
  unit.due_ns = unit.phase_ns + unit.count * unit.cycle_ns +
                nanoseconds(grid + std::clamp(stray, -most, most));
  ++unit.count;
}

void CarBus::advance(std::int64_t from_ns, const PlantOutput& from, std::int64_t to_ns,
                     const PlantOutput& to, std::vector<can::Frame>& frames) {
  if (past_.empty()) past_.add(from_ns, from);
  past_.add(to_ns, to);
  while (true) {
    const auto next = std::ranges::min_element(units_, {}, &Unit::due_ns);
    if (next->due_ns > to_ns) return;
    sample(*next);
    frames.push_back(transmit(*next));
    schedule(*next);
  }
}

PlantOutput CarBus::car_before(std::int64_t time_ns, Parameter latency) const {
  return past_.at(time_ns - nanoseconds(truth_[latency]));
}

void CarBus::sample(Unit& unit) {
  can::MessageEncoder& encoder = unit.encoder;
  const double dt = unit.count > 1 ? seconds(unit.due_ns - unit.last_ns) : seconds(unit.cycle_ns);
  const double measured_dt = dt / (1.0 + truth_[clock_error]);
  const std::string& name = encoder.message().name;
  if (name == "IMU") {
    const ImuReading reading = imu_.read(car_before(unit.due_ns, gyro_latency),
                                         car_before(unit.due_ns, accel_latency), dt);
    encoder.set("YawRate", reading.yaw_rate);
    encoder.set("AccX", reading.accel_x);
    encoder.set("AccY", reading.accel_y);
  } else if (name == "STEERING") {
    encoder.set("SteeringAngle", steering_.read(car_before(unit.due_ns, steering_latency)));
  } else {
    const PlantOutput car = car_before(unit.due_ns, wheel_latency);
    const bool front = name == "WHEELS_FRONT";
    encoder.set(front ? "WheelFrontLeft" : "WheelRearLeft",
                wheels_[front ? front_left : rear_left].read(car, measured_dt));
    encoder.set(front ? "WheelFrontRight" : "WheelRearRight",
                wheels_[front ? front_right : rear_right].read(car, measured_dt));
  }
}

// A frame waits until the bus is free, takes its time on the wire, and is stamped by the kernel
// after a random delay.
can::Frame CarBus::transmit(Unit& unit) {
  bus_free_ns_ = std::max(bus_free_ns_, unit.due_ns) + frame_ns;
  const std::int64_t seen =
      bus_free_ns_ + nanoseconds(truth_[stamp_jitter] * stamp_noise_.exponential());
  last_stamp_ns_ = std::max(whole_microseconds(seen), last_stamp_ns_ + 1000);
  return unit.encoder.frame(last_stamp_ns_);
}

}  // namespace odomd::sim
